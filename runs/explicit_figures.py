"""Figures of explicit relaxation: time per step, and agreement with the implicit states.

    python runs/explicit_figures.py [--edges 100]

Pushes the paper's rod (paper-text.toml) implicitly to 0.1, 0.5, 1.0 and 2.1 pi, disturbs each state by
about 1e-3 D, relaxes it with FIRE and with kinetic damping, and prints the differences in energy and end
tension. The time per step is the best of many batches at 0.5 pi, of the whole hot loop.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import numpy as np
from bench.stepping import disturbed, explicit_step

import derod
from derod.equilibrium.loop import relax
from derod.equilibrium.methods import make_relaxer
from derod.equilibrium.system import System
from derod.pushing.driver import frame_of
from derod.pushing.encode import decode
from derod.rod.state import State

SCENE = Path(__file__).with_name("paper-text.toml")
STOPS = (0.1, 0.5, 1.0, 2.1)  # pi
METHODS = ("fire", "kinetic")


class Row(NamedTuple):
    """One relaxation, compared with the implicit state."""

    stop: float
    method: str
    outcome: str
    steps: int
    residual: float
    seconds: float
    energy_difference: float
    tension_difference: float


def implicit_states(edges: int, stops: tuple[float, ...]) -> tuple[System, list[State]]:
    """Push implicitly; return the system and the states at ``stops`` (pi)."""
    landings = [stop * np.pi for stop in stops]
    scene = derod.load_scene(SCENE).replace(
        {"mesh.edges": edges, "push.stop": landings[-1], "push.at": landings[:-1]}
    )
    run = derod.push(scene)
    system = System(scene)
    states = [decode(system, frame_of(run, i)) for i in range(len(run))]
    return system, [
        min(states, key=lambda state: abs(state.end_shortening - at)) for at in landings
    ]


def energy_and_tension(system: System, state: State) -> tuple[float, float]:
    """Return E_hat and t."""
    system.gradient(state)
    return system.energy_hat(state), system.end_tension(state)


def agreement(edges: int) -> Iterator[Row]:
    """Relax disturbed states with every explicit method."""
    system, states = implicit_states(edges, STOPS)
    for stop, state in zip(STOPS, states, strict=True):
        energy, tension = energy_and_tension(system, state)
        for method in METHODS:
            clock = time.perf_counter()
            solution = relax(make_relaxer(method), system, disturbed(state))
            seconds = time.perf_counter() - clock
            new_energy, new_tension = energy_and_tension(system, solution.state)
            yield Row(
                stop,
                method,
                str(solution.outcome),
                solution.iterations,
                solution.residual,
                seconds,
                new_energy - energy,
                new_tension - tension,
            )


def time_per_step(edges: int, method: str) -> float:
    """Return the best time per step, seconds, over batches of the hot loop."""
    system, (state,) = implicit_states(edges, (0.5,))
    return explicit_step(system, state, method)


def main() -> None:
    """Print both tables."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--edges", type=int, default=100, help="of the agreement table")
    edges = parser.parse_args().edges
    print("edges method  us/step")
    for count in (100, 400, 800):
        for method in METHODS:
            print(f"{count:5d} {method:8s} {1e6 * time_per_step(count, method):6.2f}", flush=True)
    print("delta/pi method   outcome     steps  residual  seconds   E - E_impl   t - t_impl")
    for row in agreement(edges):
        print(
            f"{row.stop:8.2f} {row.method:8s} {row.outcome:9s} {row.steps:7d} {row.residual:9.1e}"
            f" {row.seconds:8.2f} {row.energy_difference:12.2e} {row.tension_difference:12.2e}",
            flush=True,
        )


if __name__ == "__main__":
    main()
