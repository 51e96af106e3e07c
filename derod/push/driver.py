"""The quasi-static push: settle, record, step, and deal with what happens on the way.

Every increment moves the end clamp, predicts the state along the branch, relaxes it, counts its
unstable modes, and, where there is one, kicks the rod along it and lets it descend. The increment
adapts to how hard the last one was. The push goes on from what was recorded, so that a resumed run
follows the same numbers as one that was never stopped.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from functools import partial
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from derod.equilibrium import Outcome as RelaxOutcome
from derod.equilibrium import Report, Solution, make_relaxer, relax
from derod.equilibrium.stability import Equilibrium, analyse
from derod.equilibrium.system import System
from derod.errors import RecordError
from derod.push import interrupts
from derod.push.descent import Descender, Noise
from derod.push.encode import Settled, decode, encode
from derod.push.frames import Ending, Event, Frame, Observer, Outcome, RelaxationObserver
from derod.push.guess import bent_guess
from derod.push.ledger import Verdict, compare
from derod.push.predict import predict
from derod.rod.state import State
from derod.scene import Scene
from derod.scene.resolution import COARSE, edges_enough

if TYPE_CHECKING:
    from derod.record import Run

FIRST_STEP = 0.1  # of push.max_step
LEAST_STEP = 1e-4  # of push.max_step
SHORT_STEP = 0.05  # of push.max_step; increments that converge are not made shorter than this
GROW, SHRINK = 1.5, 0.5
OUTER_LEAST = 0.01  # D; a rod with less outside the drop has run out
LEAD_IN = 0.02 * np.pi  # D; a push that starts further in is led there from here
FOLD_STEP = (
    0.05  # of push.max_step, and no more than LEAD_IN / 20: a fold is passed by no longer increment
)
LEAVING = 0.02 * np.pi  # D, beyond which an instability is not left, but looked for nearer


class Stuck(Exception):  # noqa: N818 - an ending, not an error
    """The push cannot go on."""

    def __init__(self, outcome: Outcome, message: str) -> None:
        super().__init__(message)
        self.outcome = outcome


class Increment(NamedTuple):
    """A settled increment, before it is recorded."""

    state: State
    here: Equilibrium
    iterations: int
    residual: float
    smooth: bool
    defect: float = 0.0  # energy beyond the end's work since the state before, K/D


class Push:
    """One push under way."""

    def __init__(self, scene: Scene, observers: Sequence[Observer]) -> None:
        self.scene = scene
        self.system = System(scene)
        self.relaxer = make_relaxer(scene.relax.method)
        self.observers = observers
        self.watchers = [o for o in observers if isinstance(o, RelaxationObserver)]
        self.max_step = scene.push.max_step
        self.step = FIRST_STEP * self.max_step
        self.count = 0
        self.segment = 0
        self.clock = time.perf_counter()
        self.recording = True
        self.state: State
        self.here: Equilibrium
        self.before: State | None = None
        self.turning = 0.0  # rad, the largest at a node of the last row

    # -- the path

    def begin(self) -> None:
        """Settle the first state, led in from a hair's breadth if it lies far in."""
        start = self.scene.push.start
        near = min(start, LEAD_IN)
        guess = bent_guess(self.system, near)
        solution = self.relax(guess)
        if not solution.converged:
            solution = self.descender().descend(guess).solution
        if not solution.converged:
            raise Stuck(
                outcome_of(solution.outcome),
                f"no first equilibrium from the bent guess: {solution.message}",
            )
        self.recording = near == start
        here = self.analyse(solution.state)
        increment = Increment(
            solution.state, here, solution.iterations, solution.residual, smooth=False
        )
        self.accept(self.settle_down(increment), landing=near == start)
        if not self.recording:
            self.advance_to(start, [])
            self.recording = True
            self.accept(self.increment_here(), landing=True)

    def begin_again(self, run: Run) -> None:
        """Take up a recorded run after its last frame."""
        frames = [frame_of(run, i) for i in range(max(len(run) - 2, 0), len(run))]
        row = frames[-1].row
        self.state = decode(self.system, frames[-1])
        if row["smooth"] and len(frames) == 2:
            self.before = decode(self.system, frames[0])
        self.here = self.analyse(self.state)
        self.step = float(row["next_step"])
        self.segment = int(row["segment"])
        self.count = len(run)
        self.turning = float(row["turning_angle"])
        self.clock -= float(row["wall_time"])

    def run(self) -> Ending:
        """Follow the turning points of ``push.stop`` to the last."""
        stops = self.scene.push.stop
        for segment in range(self.segment, len(stops)):
            if segment > self.segment:
                self.segment = segment
                delta = self.state.end_shortening
                self.tell("turn", delta, np.nan, np.nan, f"turn toward {stops[segment]:.6g}")
            self.advance_to(stops[segment], self.scene.push.at)
        delta = self.state.end_shortening
        return Ending(Outcome.COMPLETED, f"reached end-shortening {delta:.6g}", delta)

    def advance_to(self, stop: float, landings: Sequence[float]) -> None:
        """Push to ``stop``, landing on the way on every one of ``landings`` exactly."""
        while self.state.end_shortening != stop:
            delta = self.state.end_shortening
            forward = stop > delta
            ahead = [x for x in landings if min(delta, stop) < x < max(delta, stop)]
            goal = (min(ahead) if forward else max(ahead)) if ahead else stop
            self.advance(goal)

    def advance(self, goal: float) -> None:
        """Settle and record one increment toward ``goal``, halving it until it converges."""
        while True:
            delta = self.state.end_shortening
            target = next_target(delta, goal, self.step)
            increment = self.attempt(target)
            if increment is not None:
                self.accept(increment, landing=target == goal)
                return

    def attempt(self, target: float) -> Increment | None:
        """Try to settle at ``target``; return None, with a shorter step, where that must be retried."""
        length = abs(target - self.state.end_shortening)
        increment, reason = self.follow(target)
        if increment is not None:
            self.adapt(length, increment.iterations)
            return self.settle_down(increment)
        if length > self.shortest():
            self.step = max(SHRINK * length, 0.99 * self.shortest())
            self.tell_halving(reason)
            return None
        return self.pass_over(target, reason)

    def shortest(self) -> float:
        """Return the length (D) of an increment that ends in a descent if the branch ends within it."""
        fold = min(FOLD_STEP * self.max_step, FOLD_STEP * LEAD_IN)
        stable = self.here.unstable_modes == 0
        return fold if stable else LEAST_STEP * self.max_step

    def follow(self, target: float) -> tuple[Increment | None, str]:
        """Follow the branch to ``target``; return the increment, or None and why it may not stand."""
        guess = predict(self.system, self.state, self.here, self.before, target)
        if guess is None:
            return None, "no sound prediction reaches that far"
        solution = self.relax(guess)
        if not solution.converged:
            return None, solution.message
        here = self.analyse(solution.state)
        entry = compare(self.here, here)
        if entry.verdict is not Verdict.BALANCED:
            return None, entry.message
        length = abs(target - self.state.end_shortening)
        if here.unstable_modes > self.here.unstable_modes and length > LEAVING * (1 + 1e-9):
            return None, f"{here.unstable_modes} unstable modes appear on the way"
        increment = Increment(
            solution.state, here, solution.iterations, solution.residual, True, entry.defect
        )
        return increment, ""

    def pass_over(self, target: float, reason: str) -> Increment | None:
        """Go down from the last state, moved to ``target``, where no neighbouring state was found.

        At a fold that is the way along its soft mode to the next minimum.
        """
        length = abs(target - self.state.end_shortening)
        start = self.state.copy()
        start.clamp_at(target, self.system.physics.length)
        descent = self.descender().descend(start)
        if not descent.stable and not (descent.here and self.scene.noise.amplitude == 0):
            self.shorten(length, descent.solution.outcome, descent.solution.message)
            return None
        assert descent.here is not None
        entry = compare(self.here, descent.here, along=False)
        if entry.verdict is Verdict.LOST:
            descent = self.descender().probe(start, descent)
        here = descent.here
        assert here is not None
        entry = compare(self.here, here, along=False)
        if entry.verdict is Verdict.GAINED:
            self.shorten(length, None, entry.message)
            return None
        if entry.verdict is Verdict.LOST or descent.kicks:
            sides = descent.sides()
            moved = farthest_move(self.state, descent.solution.state)
            self.tell(
                "snap",
                target,
                self.here.energy + self.capillary_work(self.state.end_shortening),
                here.energy + self.capillary_work(target),
                f"the branch ends ({reason}); descended from {self.state.end_shortening:.6g} to the next "
                f"minimum, nodes moved {moved:.3g} D{'; ' * bool(sides)}"
                f"{sides}",
            )
        self.step = FIRST_STEP * self.max_step
        return Increment(
            descent.solution.state,
            here,
            descent.iterations,
            descent.solution.residual,
            False,
            entry.defect,
        )

    def capillary_work(self, end_shortening: float) -> float:
        """Return E_hat - E_tot, K/D."""
        return self.system.physics.capillary_force * (end_shortening + 1)

    def relax(self, start: State, *, descend: bool = False) -> Solution:
        """Relax ``start``, under the eyes of those who want to see every step."""

        def watch(iteration: int, state: State, report: Report) -> None:
            for observer in self.watchers:
                observer.relaxation(self.count, iteration, state, report)

        return relax(
            self.relaxer,
            self.system,
            start,
            watch=watch if self.watchers else None,
            descend=descend,
            kick=self.scene.noise.amplitude,
        )

    def descender(self) -> Descender:
        """Return what goes down to minima in the present increment."""
        noise = self.scene.noise
        return Descender(
            self.system,
            partial(self.relax, descend=True),
            self.analyse,
            Noise(noise.seed, self.count, noise.amplitude),
        )

    def analyse(self, state: State) -> Equilibrium:
        """Measure a settled state."""
        return analyse(self.system, state, self.relaxer.tolerance)

    def shorten(self, length: float, outcome: RelaxOutcome | None, reason: str) -> None:
        """Shorten the step after an increment that failed in every way, or give up."""
        self.step = SHRINK * length
        delta = self.state.end_shortening
        if self.step < LEAST_STEP * self.max_step:
            if self.system.outer_length(self.state) < 10 * OUTER_LEAST:
                raise Stuck(Outcome.ROD_RAN_OUT, f"the outer rod ran out at {delta:.6g}")
            raise Stuck(
                outcome_of(outcome),
                f"no way on beyond {delta:.6g} with steps down to {self.step:.3g}: {reason}",
            )
        self.tell_halving(reason)

    def tell_halving(self, reason: str) -> None:
        """Say that an increment is retried with a shorter step."""
        delta = self.state.end_shortening
        self.tell("halving", delta, np.nan, np.nan, f"step to {self.step:.3g}: {reason}")

    def adapt(self, length: float, iterations: int) -> None:
        """Set the next step from how hard this increment was."""
        if iterations > self.relaxer.hard:
            self.step = max(SHRINK * length, SHORT_STEP * self.max_step)
        elif iterations <= self.relaxer.easy and length > 0.5 * self.step:
            self.step = min(GROW * self.step, self.max_step)

    # -- stability

    def settle_down(self, increment: Increment) -> Increment:
        """Where a settled state has unstable modes, kick it and descend until there are none."""
        state, here = increment.state, increment.here
        if here.unstable_modes == 0 or self.scene.noise.amplitude == 0:
            return increment
        settled = Solution(
            state, RelaxOutcome.CONVERGED, increment.iterations, increment.residual, ""
        )
        descent = self.descender().leave(settled, here)
        if not descent.stable or descent.here is None:
            raise Stuck(
                Outcome.NOT_CONVERGED,
                f"{here.unstable_modes} unstable modes at {state.end_shortening:.6g} could not be left by "
                f"{len(descent.kicks)} kicks: {descent.solution.message}",
            )
        entry = compare(here, descent.here, along=False)
        if entry.verdict is Verdict.GAINED:
            raise Stuck(Outcome.OUT_OF_BALANCE, f"after a kick: {entry.message}")
        potential = self.capillary_work(state.end_shortening)
        self.tell(
            "instability",
            state.end_shortening,
            here.energy + potential,
            descent.here.energy + potential,
            f"{here.unstable_modes} unstable modes, the lowest kicked; "
            f"{descent.sides()}; descended, nodes moved {farthest_move(state, descent.solution.state):.3g} D",
        )
        return Increment(
            descent.solution.state,
            descent.here,
            descent.iterations,
            descent.solution.residual,
            smooth=False,
            defect=increment.defect + entry.defect,
        )

    # -- the record

    def accept(self, increment: Increment, *, landing: bool) -> None:
        """Make ``increment`` the present state, and record it."""
        previous = getattr(self, "state", None)
        frame = self.record(increment, landing=landing) if self.recording else None
        self.state = increment.state if frame is None else decode(self.system, frame)
        unchanged = self.state.equals(increment.state)  # always, where K = K0
        self.here = increment.here if unchanged else self.analyse(self.state)
        self.before = previous if increment.smooth else None
        if self.system.outer_length(self.state) < OUTER_LEAST:
            raise Stuck(
                Outcome.ROD_RAN_OUT, f"the outer rod ran out at {self.state.end_shortening:.6g}"
            )

    def increment_here(self) -> Increment:
        """Return the present state as an increment."""
        _, residual = (self.system.gradient(self.state), self.system.excess(1.0)[1])
        return Increment(self.state, self.here, 0, residual, smooth=False)

    def record(self, increment: Increment, *, landing: bool) -> Frame:
        """Hand the increment to the observers as a frame."""
        settled = Settled(
            increment=self.count,
            segment=self.segment,
            smooth=increment.smooth,
            landing=landing,
            unstable_modes=increment.here.unstable_modes,
            residual=increment.residual,
            work_defect=increment.defect,
            iterations=increment.iterations,
            next_step=self.step,
            wall_time=time.perf_counter() - self.clock,
        )
        frame = encode(self.system, increment.state, increment.here, settled)
        turning = float(frame.row["turning_angle"])
        if turning > COARSE >= self.turning:
            self.tell(
                "coarse",
                increment.state.end_shortening,
                np.nan,
                np.nan,
                f"the rod turns by {turning:.3g} rad at a node: the mesh is too coarse for the coil; "
                f"{edges_enough(self.system.edges, turning)} edges would do",
            )
        self.turning = turning
        for observer in self.observers:
            observer.frame(frame)
        self.count += 1
        return frame

    def tell(self, kind: str, delta: float, before: float, after: float, message: str) -> None:
        """Hand an event to the observers."""
        if not self.recording:
            return
        unit = self.system.bending
        event = Event(self.count, kind, delta, before * unit, after * unit, message)
        for observer in self.observers:
            observer.event(event)


def next_target(delta: float, goal: float, step: float) -> float:
    """Return where the next increment ends: ``step`` on, or the goal, or half way where it is near."""
    distance = abs(goal - delta)
    if step >= distance * (1 - 1e-9):
        return goal
    if 2 * step > distance:
        step = 0.5 * distance
    return delta + step if goal > delta else delta - step


def outcome_of(outcome: RelaxOutcome | None) -> Outcome:
    """Return the push's outcome for a relaxation that did not converge; None: it gained energy."""
    kinds = {None: Outcome.OUT_OF_BALANCE, RelaxOutcome.DIVERGED: Outcome.DIVERGED}
    return kinds.get(outcome, Outcome.NOT_CONVERGED)


def farthest_move(before: State, after: State) -> float:
    """Return how far a node moved between two states, D."""
    d = before.dimension
    return float(np.abs(after.q[:, :d] - before.q[:, :d]).max())


def frame_of(run: Run, i: int) -> Frame:
    """Return a recorded frame."""
    return Frame(
        run.table[i], run.positions(i), run.arc_length(i), run.drop_center(i), run.edge_tension(i)
    )


def drive(scene: Scene, observers: Sequence[Observer], resume: Run | None = None) -> Ending:
    """Run the push of ``scene`` and hand every frame and event to ``observers``, in order.

    With ``resume`` the push goes on after that run's last frame. Ctrl-C ends it with what is
    recorded. Returns how it ended; raises nothing but programming errors.
    """
    push = Push(scene, observers)
    going_on = resume is not None and len(resume) > 0
    try:
        if resume is not None and going_on:
            push.begin_again(resume)
        for observer in observers:
            observer.start(scene, push.count)
        if not going_on:
            push.begin()
        ending = push.run()
    except Stuck as stuck:
        ending = Ending(stuck.outcome, str(stuck), where(push))
    except KeyboardInterrupt:
        place = where(push)
        said = "before the first increment" if np.isnan(place) else f"at {place:.6g}"
        ending = Ending(Outcome.INTERRUPTED, f"{interrupts.words()} {said}", place)
    except RecordError as error:
        ending = Ending(Outcome.RECORD_FAILED, str(error), where(push))
    for observer in observers:
        observer.finish(ending)
    return ending


def where(push: Push) -> float:
    """Return the end-shortening of the last settled state, nan before the first."""
    state = getattr(push, "state", None)
    return np.nan if state is None else state.end_shortening
