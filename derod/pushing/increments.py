"""How one increment is settled: along the branch, or over its end, and down from what is unstable."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import NamedTuple

from derod.equilibrium.control import Control
from derod.equilibrium.loop import Outcome as RelaxOutcome
from derod.equilibrium.loop import Relaxer, Solution, relax
from derod.equilibrium.measured import Measured, measure
from derod.equilibrium.system import System
from derod.pushing.descent import Descender, Descent, Noise
from derod.pushing.frames import Outcome
from derod.pushing.ledger import Verdict, compare
from derod.pushing.locating import crossing, fold
from derod.pushing.predict import predict
from derod.pushing.stride import Stride
from derod.pushing.stuck import Stuck, outcome_of
from derod.pushing.telling import Telling
from derod.pushing.words import after_semicolon, moved, slid
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
        self.locates = False  # whether events are looked for between increments

    def attempt(self, here: Measured, before: Measured | None, target: float) -> Increment | None:
        """Try to settle at ``target``; return None, with a shorter stride, where that must be retried."""
        length = abs(target - here.control_value)
        increment, reason = self.follow(here, before, target)
        if increment is not None:
            count = increment.iterations
            self.stride.adapt(
                length, hard=count > self.relaxer.hard, easy=count <= self.relaxer.easy
            )
            return self.settle_down(increment, here)
        shortest = self.stride.shortest(stable=here.unstable_modes == 0)
        if length > shortest:
            self.stride.shorten(length, shortest)
            self.tell_halving(here, reason)
            return None
        return self.pass_over(here, before, target, reason)

    def follow(
        self, here: Measured, before: Measured | None, target: float
    ) -> tuple[Increment | None, str]:
        """Follow the branch to ``target``; return the increment, or None and why it may not stand."""
        solution, reason = self.reach(here, before, target)
        if solution is None:
            return None, reason
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

    def reach(
        self, here: Measured, before: Measured | None, target: float
    ) -> tuple[Solution | None, str]:
        """Relax what the branch predicts at ``target``; return it, or None and why it is not there."""
        guess = predict(self.system, self.control, here, before, target)
        if guess is None:
            return None, "no sound prediction reaches that far"
        solution = self.relax(guess)
        return (solution, "") if solution.converged else (None, solution.message)

    def trace(self, here: Measured, before: Measured, target: float) -> Measured | None:
        """Settle on the branch of two states at a value of the control, to look at what is there."""
        solution, _ = self.reach(here, before, target)
        return None if solution is None else self.measure(solution.state)

    def pass_over(
        self, here: Measured, before: Measured | None, target: float, reason: str
    ) -> Increment | None:
        """Go down from the last state, moved to ``target``, where no neighbouring state was found.

        At a fold that is the way along its soft mode to the next minimum.
        """
        start = here.state.copy()
        self.control.set(start, target)
        descent = self.descender().descend(start)
        self.check_outer_rod(descent, lambda: self.end_of_branch(here, before))
        if not descent.stable and not (descent.here and self.noise.amplitude == 0):
            self.shorten(here, target, descent.solution.outcome, descent.solution.message)
            return None
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
            place, _ = self.end_of_branch(here, before)
            lost = -entry.defect * self.system.bending
            located = "" if place == here.control_value else f" at {self.place(place, 9)}"
            begun = self.place(here.control_value)
            self.telling.event(
                "snap",
                there.state.end_shortening,
                f"the branch ends{located} ({reason}); descended from {begun} to the next minimum"
                f"{slid(here, there, lost)}, {moved(here, there)}{after_semicolon(descent.sides())}",
                here.energy_hat,
                there.energy_hat,
                self.told(place),
            )
        self.stride.start_again()
        return Increment(there, descent.iterations, descent.solution.residual, False, entry.defect)

    def settle_down(self, increment: Increment, before: Measured | None = None) -> Increment:
        """Where a settled state has unstable modes, kick it and descend until there are none.

        ``before`` is the state before it on the same branch, if there is one.
        """
        here = increment.here
        if here.unstable_modes == 0 or self.noise.amplitude == 0:
            return increment
        state = here.state
        settled = Solution(
            state, RelaxOutcome.CONVERGED, increment.iterations, increment.residual, ""
        )
        descent = self.descender().leave(settled, here)
        self.check_outer_rod(descent, lambda: self.loss_of_stability(here, before))
        if not descent.stable or descent.here is None:
            raise Stuck(
                Outcome.NOT_CONVERGED,
                f"{here.unstable_modes} unstable modes at {self.place(here.control_value)} could not be "
                f"left by {len(descent.kicks)} kicks: {descent.solution.message}",
            )
        there = descent.here
        entry = compare(here, there, along=False)
        if entry.verdict is Verdict.GAINED:
            raise Stuck(Outcome.OUT_OF_BALANCE, f"after a kick: {entry.message}")
        place, lost = self.loss_of_stability(here, before)
        self.telling.event(
            "instability",
            state.end_shortening,
            f"{lost}{'; ' * bool(lost)}{here.unstable_modes} unstable modes, the lowest kicked; "
            f"{descent.sides()}; descended, {moved(here, there)}",
            here.energy_hat,
            there.energy_hat,
            self.told(place),
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

    def end_of_branch(self, here: Measured, before: Measured | None) -> tuple[float, str]:
        """Return the control's value at which the branch ends, and words for it where it was located."""
        place = None
        if self.locates and before is not None:
            place = fold(before, here, self.stride.usual, self.trace)
        if place is None:
            return here.control_value, ""
        return place, f"the branch ends at {self.place(place, 9)}"

    def loss_of_stability(self, here: Measured, before: Measured | None) -> tuple[float, str]:
        """Return the control's value at which the branch gets unstable, and words where it was located."""
        place = None
        if self.locates and before is not None and before.unstable_modes == 0:
            place = crossing(self.system, before, here, self.stride.usual, self.trace)
        if place is None:
            return here.control_value, ""
        return place, f"stable up to {self.place(place, 9)}"

    def check_outer_rod(
        self, descent: Descent, last_stable: Callable[[], tuple[float, str]]
    ) -> None:
        """Where a descent under a dead load has wound in all the rod there is, no stable state is left.

        ``last_stable`` tells where the last one was, by the control, and in words.
        """
        state = descent.solution.state
        if not state.physics.slides or self.system.outer_length(state) >= 10 * OUTER_LEAST:
            return
        place, words = last_stable()
        told = words or f"the last stable state lies near {self.place(place)}"
        message = (
            f"{told}; none is left: the rod runs in until the outer rod has run out, at end-shortening "
            f"{state.end_shortening:.6g}"
        )
        self.telling.event("snap", state.end_shortening, message, value=self.told(place))
        raise Stuck(Outcome.ROD_RAN_OUT, message)

    @property
    def unit(self) -> float:
        """Return what turns the control's value into that of files."""
        return float(self.system.bending**self.control.power)

    def told(self, value: float) -> float:
        """Return a value of the control in the units of files."""
        return value * self.unit

    def place(self, value: float, digits: int = 6) -> str:
        """Return a value of the control in words, in the units of files."""
        number = f"{self.told(value):.{digits}g}"
        return number if self.control.name == "end_shortening" else f"{self.words} {number}"

    def tell_halving(self, here: Measured, reason: str) -> None:
        """Say that an increment is retried with a shorter step."""
        self.telling.event(
            "halving",
            here.state.end_shortening,
            f"step to {self.told(self.stride.length):.3g}: {reason}",
            value=self.told(here.control_value),
        )
