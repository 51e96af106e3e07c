"""How one increment is settled: along the branch, or over its end, and down from what is unstable."""

from __future__ import annotations

from functools import partial
from typing import NamedTuple

import numpy as np

from derod.equilibrium.control import Control
from derod.equilibrium.loop import Outcome as RelaxOutcome
from derod.equilibrium.loop import Relaxer, Solution, relax
from derod.equilibrium.measured import Measured, measure
from derod.equilibrium.system import System
from derod.push.descent import Descender, Descent, Noise
from derod.push.frames import Outcome
from derod.push.ledger import Verdict, compare
from derod.push.predict import predict
from derod.push.stride import Stride
from derod.push.stuck import Stuck, outcome_of
from derod.push.telling import Telling
from derod.rod.state import State
from derod.scene.tables import Noise as NoiseOptions

OUTER_LEAST = 0.01  # D; a rod with less outside the drop has run out


class Increment(NamedTuple):
    """A settled increment, before it is recorded."""

    here: Measured
    iterations: int
    residual: float
    smooth: bool
    defect: float = 0.0  # energy beyond the control's work since the state before, K/D


class Increments:
    """Settles increments of one control after another."""

    def __init__(
        self, system: System, relaxer: Relaxer, telling: Telling, noise: NoiseOptions
    ) -> None:
        self.system = system
        self.relaxer = relaxer
        self.telling = telling
        self.noise = noise
        self.control: Control
        self.stride: Stride
        self.words = ""  # what the control is called in sentences

    def attempt(self, here: Measured, before: State | None, target: float) -> Increment | None:
        """Try to settle at ``target``; return None, with a shorter stride, where that must be retried."""
        length = abs(target - here.control_value)
        increment, reason = self.follow(here, before, target)
        if increment is not None:
            count = increment.iterations
            self.stride.adapt(
                length, hard=count > self.relaxer.hard, easy=count <= self.relaxer.easy
            )
            return self.settle_down(increment)
        shortest = self.stride.shortest(stable=here.unstable_modes == 0)
        if length > shortest:
            self.stride.shorten(length, shortest)
            self.tell_halving(here, reason)
            return None
        return self.pass_over(here, target, reason)

    def follow(
        self, here: Measured, before: State | None, target: float
    ) -> tuple[Increment | None, str]:
        """Follow the branch to ``target``; return the increment, or None and why it may not stand."""
        guess = predict(self.system, self.control, here, before, target)
        if guess is None:
            return None, "no sound prediction reaches that far"
        solution = self.relax(guess)
        if not solution.converged:
            return None, solution.message
        there = self.measure(solution.state)
        entry = compare(here, there)
        if entry.verdict is not Verdict.BALANCED:
            return None, entry.message
        length = abs(target - here.control_value)
        appeared = there.unstable_modes > here.unstable_modes
        if appeared and length > self.stride.usual * (1 + 1e-9):
            return None, f"{there.unstable_modes} unstable modes appear on the way"
        increment = Increment(there, solution.iterations, solution.residual, True, entry.defect)
        return increment, ""

    def pass_over(self, here: Measured, target: float, reason: str) -> Increment | None:
        """Go down from the last state, moved to ``target``, where no neighbouring state was found.

        At a fold that is the way along its soft mode to the next minimum.
        """
        start = here.state.copy()
        self.control.set(start, target)
        descent = self.descender().descend(start)
        if not descent.stable and not (descent.here and self.noise.amplitude == 0):
            self.check_outer_rod(descent, target)
            self.shorten(here, target, descent.solution.outcome, descent.solution.message)
            return None
        self.check_outer_rod(descent, target)
        assert descent.here is not None
        entry = compare(here, descent.here, along=False)
        if entry.verdict is Verdict.LOST:
            descent = self.descender().probe(start, descent)
        there = descent.here
        assert there is not None
        entry = compare(here, there, along=False)
        if entry.verdict is Verdict.GAINED:
            self.shorten(here, target, None, entry.message)
            return None
        if entry.verdict is Verdict.LOST or descent.kicks:
            self.tell_snap(here, there, target, reason, descent, entry.defect)
        self.stride.start_again()
        return Increment(there, descent.iterations, descent.solution.residual, False, entry.defect)

    def settle_down(self, increment: Increment) -> Increment:
        """Where a settled state has unstable modes, kick it and descend until there are none."""
        here = increment.here
        if here.unstable_modes == 0 or self.noise.amplitude == 0:
            return increment
        state = here.state
        settled = Solution(
            state, RelaxOutcome.CONVERGED, increment.iterations, increment.residual, ""
        )
        descent = self.descender().leave(settled, here)
        if not descent.stable or descent.here is None:
            self.check_outer_rod(descent, here.control_value)
            raise Stuck(
                Outcome.NOT_CONVERGED,
                f"{here.unstable_modes} unstable modes at {self.place(here.control_value)} could not be "
                f"left by {len(descent.kicks)} kicks: {descent.solution.message}",
            )
        self.check_outer_rod(descent, here.control_value)
        there = descent.here
        entry = compare(here, there, along=False)
        if entry.verdict is Verdict.GAINED:
            raise Stuck(Outcome.OUT_OF_BALANCE, f"after a kick: {entry.message}")
        self.telling.event(
            "instability",
            state.end_shortening,
            f"{here.unstable_modes} unstable modes, the lowest kicked; {descent.sides()}; descended, "
            f"{moved(here, there)}",
            here.energy_hat,
            there.energy_hat,
        )
        return Increment(
            there,
            descent.iterations,
            descent.solution.residual,
            smooth=False,
            defect=increment.defect + entry.defect,
        )

    def relax(self, start: State, *, descend: bool = False) -> Solution:
        """Relax ``start``, under the eyes of those who want to see every step."""
        return relax(
            self.relaxer,
            self.system,
            start,
            watch=self.telling.step if self.telling.watchers else None,
            descend=descend,
            kick=self.noise.amplitude,
        )

    def descender(self) -> Descender:
        """Return what goes down to minima in the present increment."""
        return Descender(
            self.system,
            partial(self.relax, descend=True),
            self.measure,
            Noise(self.noise.seed, self.telling.count, self.noise.amplitude),
        )

    def measure(self, state: State) -> Measured:
        """Measure a settled state."""
        return measure(self.system, state, self.control, self.relaxer.tolerance)

    def shorten(
        self, here: Measured, target: float, outcome: RelaxOutcome | None, reason: str
    ) -> None:
        """Shorten the stride after an increment that failed in every way, or give up."""
        self.stride.shorten(abs(target - here.control_value))
        place = self.place(here.control_value)
        if self.stride.length < self.stride.least:
            if self.system.outer_length(here.state) < 10 * OUTER_LEAST:
                raise Stuck(Outcome.ROD_RAN_OUT, f"the outer rod ran out at {place}")
            raise Stuck(
                outcome_of(outcome),
                f"no way on beyond {place} with steps down to {self.stride.length:.3g}: {reason}",
            )
        self.tell_halving(here, reason)

    def check_outer_rod(self, descent: Descent, target: float) -> None:
        """Where a descent under a dead load has wound in all the rod there is, no stable state is left."""
        state = descent.solution.state
        if state.physics.slides and self.system.outer_length(state) < 10 * OUTER_LEAST:
            raise Stuck(
                Outcome.ROD_RAN_OUT,
                f"no stable state is left at {self.place(target)}: the rod runs in until the outer rod "
                f"has run out, at end-shortening {state.end_shortening:.6g}",
            )

    def place(self, value: float) -> str:
        """Return a value of the control in words, in the units of files."""
        told = value * self.system.bending**self.control.power
        return (
            f"{told:.6g}" if self.control.name == "end_shortening" else f"{self.words} {told:.6g}"
        )

    def tell_halving(self, here: Measured, reason: str) -> None:
        """Say that an increment is retried with a shorter step."""
        self.telling.event(
            "halving",
            here.state.end_shortening,
            f"step to {self.stride.length * self.system.bending**self.control.power:.3g}: {reason}",
        )

    def tell_snap(
        self,
        here: Measured,
        there: Measured,
        target: float,
        reason: str,
        descent: Descent,
        defect: float,
    ) -> None:
        """Say that the branch has ended, and where the rod went."""
        sides = descent.sides()
        slid = ""
        if here.state.physics.slides:
            slid = (
                f", end-shortening {here.state.end_shortening:.6g} to {there.state.end_shortening:.6g}, "
                f"energy lost {-defect * self.system.bending:.6g}"
            )
        self.telling.event(
            "snap",
            there.state.end_shortening,
            f"the branch ends ({reason}); descended from {self.place(here.control_value)} to the next "
            f"minimum{slid}, {moved(here, there)}{'; ' * bool(sides)}{sides}",
            here.energy_hat,
            there.energy_hat,
        )


def moved(before: Measured, after: Measured) -> str:
    """Say how far a node moved between two states."""
    d = before.state.dimension
    farthest = float(np.abs(after.state.q[:, :d] - before.state.q[:, :d]).max())
    return f"nodes moved {farthest:.3g} D"
