"""The one relaxation loop, and what a method must offer to be run by it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from enum import StrEnum
from typing import NamedTuple, Protocol

from derod.equilibrium.system import System
from derod.rod.state import State


class Outcome(StrEnum):
    """How a relaxation ended."""

    CONVERGED = "converged"
    MAX_ITERATIONS = "max_iterations"
    STALLED = "stalled"
    STRAYED = "strayed"  # left the region round the prediction that is trusted
    SADDLE = "saddle"  # on the way down, where steps leave no direction of negative curvature
    DIVERGED = "diverged"


class Report(NamedTuple):
    """What one advance did."""

    iterations: int
    excess: float  # residual over tolerance; at most 1 is settled
    residual: float  # largest force, K0/D^2
    alive: bool  # False: no further progress is possible
    sound: bool  # False: not a number, outside the wall, or folded back at a node
    strayed: bool = False  # the next step would leave the region round the prediction
    descending: bool = False  # from state to state on the constraints, downhill
    saddle: bool = False  # a kick along a mode of negative curvature gains more than such steps


@dataclass(frozen=True, slots=True)
class Solution:
    """A relaxed state and how it was reached. If not converged, the state is the last good one."""

    state: State
    outcome: Outcome
    iterations: int
    residual: float
    message: str

    @property
    def converged(self) -> bool:
        """Return whether the residual met its tolerance."""
        return self.outcome is Outcome.CONVERGED


class Relaxer(Protocol):
    """A method: ``begin`` on a state, then ``advance`` it in place until settled."""

    limit: int  # iterations after which a relaxation gives up
    easy: int  # at most that many iterations: the next increment may be longer
    hard: int  # more than that: it shall be shorter
    finest: float  # K0/D^2, the least tolerance that is worth its cost
    tolerance: float  # K0/D^2, that the last relaxation was held to
    stepwise: bool  # somebody watches: a batch of steps is one step, where the method has such

    def begin(
        self, system: System, state: State, tolerance: float, *, descend: bool, kick: float = 0.0
    ) -> Report:
        """Look at the state; keep what the method must remember."""

    def advance(self) -> Report:
        """Improve the state by one step, or one batch of steps, in place."""


Watcher = Callable[[int, State, Report], None]


def relax(
    relaxer: Relaxer,
    system: System,
    start: State,
    tolerance: float | None = None,
    *,
    descend: bool = False,
    kick: float = 0.0,
    watch: Watcher | None = None,
) -> Solution:
    """Relax a copy of ``start`` until its residual meets ``tolerance`` (K0/D^2).

    The default is the scene's tolerance, but no finer than the method's ``finest``.

    Without ``descend`` the equilibrium near ``start`` is sought, stable or not, and none that is farther from
    it than a prediction may be off: the outcome is then "strayed". With ``descend`` the state is put
    onto its constraints, and no step from there raises the energy beyond rounding. A ``kick`` (D) says that
    saddles are to be left by one: the relaxation ends with the outcome "saddle" as soon as a kick of that
    size gains more than its steps.

    ``watch(iteration, state, report)`` sees the state after every advance.
    """
    state = start.copy()
    if tolerance is None:
        tolerance = max(system.tolerance, relaxer.finest)
    relaxer.stepwise = watch is not None
    report = relaxer.begin(system, state, tolerance, descend=descend, kick=kick)
    done, seen = 0, 0  # iterations; those and the cheap steps between them
    while True:
        if watch is not None:
            watch(seen, state, report)
        outcome = judge(report, done, relaxer.limit)
        if outcome is not None:
            place = "" if report.sound else f", {system.trouble(state)}"
            message = (
                f"{outcome} after {done} iterations at end-shortening {state.end_shortening:.6g}, "
                f"largest residual force {report.residual:.3g} "
                f"(x{report.excess:.3g} of what is allowed){place}"
            )
            state.read_end()
            return Solution(state, outcome, done, report.residual, message)
        report = relaxer.advance()
        done += report.iterations
        seen += max(report.iterations, 1)


def judge(report: Report, done: int, limit: int) -> Outcome | None:
    """Return how the relaxation ended, or None while it goes on."""
    if not report.sound:
        return Outcome.DIVERGED
    if report.excess <= 1:
        return Outcome.CONVERGED
    if report.strayed:
        return Outcome.STRAYED
    if report.saddle:
        return Outcome.SADDLE
    if not report.alive:
        return Outcome.STALLED
    if done >= limit:
        return Outcome.MAX_ITERATIONS
    return None
