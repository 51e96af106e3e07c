"""Time of one implicit and one explicit step of any scene, where a push of it ends."""

from __future__ import annotations

import time

import numpy as np

import derod
from derod.equilibrium.loop import relax
from derod.equilibrium.methods import make_relaxer
from derod.equilibrium.system import System
from derod.pushing.driver import frame_of
from derod.pushing.encode import decode
from derod.rod.state import State

DISTURBANCE = 1e-3  # D
BATCHES = 40


def pushed(scene: derod.Scene) -> tuple[System, State]:
    """Push; return the system and the last state."""
    run = derod.push(scene)
    system = System(scene)
    return system, decode(system, frame_of(run, len(run) - 1))


def disturbed(state: State) -> State:
    """Return a copy with its free nodes moved smoothly in all directions."""
    rng = np.random.default_rng(0)
    place = np.linspace(0, np.pi, state.q.shape[0])[1:-1]
    moved = state.copy()
    for wave in range(1, 6):
        shift = np.outer(np.sin(wave * place), rng.normal(size=state.dimension))
        moved.q[1:-1, : state.dimension] += DISTURBANCE / wave * shift
    return moved


def implicit_step(system: System, state: State) -> float:
    """Return the best time of a whole implicit step, line search included, s."""
    best = np.inf
    for _ in range(BATCHES):
        clock = time.perf_counter()
        solution = relax(make_relaxer("implicit"), system, disturbed(state))
        best = min(best, (time.perf_counter() - clock) / max(solution.iterations, 1))
    return float(best)


def explicit_step(system: System, state: State, method: str = "fire") -> float:
    """Return the best time of an explicit step of the hot loop, s."""
    relaxer = make_relaxer(method)
    relaxer.begin(system, disturbed(state), 0.0, descend=False)
    best = np.inf
    for _ in range(BATCHES):
        relaxer.fill_masses()
        clock = time.perf_counter()
        report = relaxer.take_steps()
        if not report.iterations:  # settled
            break
        best = min(best, (time.perf_counter() - clock) / report.iterations)
    return float(best)
