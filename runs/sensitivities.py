# ruff: noqa: E402 - threads are set before numpy is imported
"""What derivatives by the scene's parameters cost, beside their errors.

    python runs/sensitivities.py            # a minute; the table of docs/sensitivities.md

The errors: derivatives by each parameter against five-point differences of re-settled states, at the end of
a push to 1.5 pi. The cost: CPU of each derivative by itself, over that of one Newton step at the same
state (gradient, Hessian, factor, solution), both taken in turns, least of many.
"""

from __future__ import annotations

import os

for name in ("OPENBLAS_NUM_THREADS", "NUMBA_NUM_THREADS", "OMP_NUM_THREADS"):
    os.environ.setdefault(name, "1")

import sys
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

import derod

# isort: split
from derod.equilibrium.parameters import CONSTANTS, of_control
from derod.equilibrium.sensitivity import Setting, parameters_of, sensitivities, solved
from derod.equilibrium.system import System
from derod.pushing.controls import CONTROLS
from derod.record.modes import state_of
from derod.record.sensitivities import sensitivities_at, slopes
from derod.rod.state import State

sys.path.insert(0, str(Path(__file__).parents[1]))
from tests.equilibrium.test_sensitivity import differences, sharpened, unturned

HERE = Path(__file__).parent
REPEATS = 200


def work_of(system: System, state: State, name: str, setting: Setting) -> Callable[[], object]:
    """Return what one derivative takes beyond the state's linearisation."""

    def work() -> object:
        if name in CONSTANTS:
            if name == "length":  # needs the gradient, and the matrix is filled once more
                system.gradient(state)
            partial = CONSTANTS[name](system, state)
        else:
            partial = of_control(CONTROLS[name], system, setting.here)
        return solved(system, setting, name, partial)

    return work


def least(works: list[Callable[[], object]]) -> list[float]:
    """Return the least CPU time of each, s, taken in turns."""
    best = [np.inf] * len(works)
    for _ in range(REPEATS):
        for k, work in enumerate(works):
            clock = time.process_time()
            work()
            best[k] = min(best[k], time.process_time() - clock)
    return best


def table(edges: int) -> list[str]:
    """The rows of one mesh."""
    scene = derod.load_scene(HERE / "paper-text.toml").replace(
        {"push.stop": "1.5 pi", "push.at": [], "mesh.edges": edges}
    )
    run = derod.push(scene)
    system, state = state_of(run, -1)
    state = sharpened(system, state)
    here, found = sensitivities(system, state, CONTROLS)
    last = system.dimension - 1
    own = float(system.room.hess.edge[system.edges, last, last])
    setting = Setting(here, *system.end_column(state), own)

    def newton() -> object:
        system.linearise(state)
        return system.solve(system.room.r[1:], setting.border * 0)

    names = [name for name in parameters_of(state) if name != "weight"]  # turns the coil
    times = least([newton, *(work_of(system, state, name, setting) for name in names)])
    together = least([newton, lambda: sensitivities_at(system, state, bounds=False)])
    lines = []
    for name, cost in zip(names, times[1:], strict=True):
        one = found[name]
        exact = unturned(differences(scene, state, name), one, state)
        errors = []
        for key in ("tension", "energy_hat", "q"):
            scale = max(np.abs(exact[key]).max(), 1e-3 * np.abs(getattr(one, key)).max(), 1e-12)
            errors.append(np.abs(getattr(one, key) - exact[key]).max() / scale)
        words = "".join(f" {error:.0e} |" for error in errors)
        lines.append(f"| {edges} | {name} |{words} {cost / times[0]:.2f} |")
    lines.append(
        f"| {edges} | all, and the state measured | | | | {together[1] / together[0]:.2f} |"
    )
    clock = time.process_time()
    slopes(run, ["capillary_force", "wall_strength"])
    spent = time.process_time() - clock
    lines.append(
        f"| {edges} | dt/dp by two of them, a row of the push | | | | {spent / len(run) / times[0]:.2f} |"
    )
    return lines


def main() -> None:
    """Print the table."""
    print(
        "| edges | parameter | error of dt/dp | of dE_hat/dp | of the shape's | cost, Newton steps |"
    )
    print("|---|---|---|---|---|---|")
    for edges in (50, 200, 800):
        for line in table(edges):
            print(line)


if __name__ == "__main__":
    main()
