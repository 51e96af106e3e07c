"""The quasi-static push: settle, record, step, and deal with what happens on the way.

Every increment moves the end clamp, predicts the state along the branch, relaxes it, counts its
unstable modes, and, where there is one, kicks the rod along it and lets it descend. The increment
adapts to how hard the last one was. The push goes on from what was recorded, so that a resumed run
follows the same numbers as one that was never stopped.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from derod.encode import Settled, decode, encode
from derod.errors import RecordError
from derod.frames import Ending, Event, Frame, Observer, Outcome, RelaxationObserver
from derod.guess import bent_guess
from derod.predict import predict
from derod.relax import Report, Solution, make_relaxer, relax
from derod.scene import Scene
from derod.stability import Equilibrium, analyse, lowest_mode
from derod.state import State
from derod.system import System

if TYPE_CHECKING:
    from derod.record import Run

FIRST_STEP = 0.1  # of push.max_step
LEAST_STEP = 1e-4  # of push.max_step
SHORT_STEP = 0.05  # of push.max_step; increments that converge are not made shorter than this
GROW, SHRINK = 1.5, 0.5
OUTER_LEAST = 0.01  # D; a rod with less outside the drop has run out
MOST_KICKS = 6
STRONGER = 4.0  # each kick than the one before
JUMP = 0.05  # D a node may settle away from its prediction before the energy is looked at
LOST_ENERGY = 1e-3  # K0/D lost beyond the work done that makes a jump a snap
SNAP_STEP = 0.05  # of push.max_step: a fold is passed by an increment no longer than this
LEAD_IN = 0.02 * np.pi  # D; a push that starts further in is led there from here


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

    # -- the path

    def begin(self) -> None:
        """Settle the first state, led in from a hair's breadth if it lies far in."""
        start = self.scene.push.start
        near = min(start, LEAD_IN)
        solution = self.relax(bent_guess(self.system, near))
        if not solution.converged:
            raise Stuck(
                outcome_of(solution),
                f"no first equilibrium from the bent guess: {solution.message}",
            )
        self.recording = near == start
        self.accept(self.settle_down(solution, smooth=False), landing=near == start)
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
        self.here = analyse(self.system, self.state)
        self.step = float(row["next_step"])
        self.segment = int(row["segment"])
        self.count = len(run)
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
        guess = predict(self.system, self.state, self.here, self.before, target)
        solution = self.relax(guess)
        if not solution.converged:
            self.retry(length, solution)
            return None
        d = self.system.dimension
        away = abs(solution.state.q[:, :d] - guess.q[:, :d]).max()
        snapped = away > JUMP and self.lost_energy(solution.state) > LOST_ENERGY
        if snapped and length > SNAP_STEP * self.max_step:
            self.step = max(0.25 * length, 0.99 * SNAP_STEP * self.max_step)
            return None
        if snapped:
            self.tell(
                "snap",
                target,
                self.system.energy_hat(self.state),
                self.system.energy_hat(solution.state),
                f"no neighbouring state; nodes moved {away:.3g} D from where the branch pointed",
            )
        increment = self.settle_down(solution, smooth=not snapped)
        self.adapt(length, solution.iterations)
        return increment

    def relax(self, start: State, *, descend: bool = False) -> Solution:
        """Relax ``start``, under the eyes of those who want to see every step."""
        if not self.watchers:
            return relax(self.relaxer, self.system, start, descend=descend)

        def watch(iteration: int, state: State, report: Report) -> None:
            for observer in self.watchers:
                observer.relaxation(self.count, iteration, state, report)

        return relax(self.relaxer, self.system, start, watch=watch, descend=descend)

    def retry(self, length: float, solution: Solution) -> None:
        """Shorten the step after an increment that did not converge, or give up."""
        self.step = SHRINK * length
        delta = self.state.end_shortening
        if self.step < LEAST_STEP * self.max_step:
            if self.system.outer_length(self.state) < 10 * OUTER_LEAST:
                raise Stuck(Outcome.ROD_RAN_OUT, f"the outer rod ran out at {delta:.6g}")
            raise Stuck(
                outcome_of(solution),
                f"no convergence beyond {delta:.6g} with steps down to {self.step:.3g}: "
                f"{solution.message}",
            )
        self.tell("halving", delta, np.nan, np.nan, f"step to {self.step:.3g}: {solution.message}")

    def lost_energy(self, new: State) -> float:
        """Return the energy lost beyond the end's work, by the trapezoidal rule, K/D."""
        tension = []
        for state in (self.state, new):
            self.system.gradient(state)
            tension.append(self.system.end_tension())
        work = -0.5 * sum(tension) * (new.end_shortening - self.state.end_shortening)
        change = self.system.energies(new).total - self.system.energies(self.state).total
        return work - change

    def adapt(self, length: float, iterations: int) -> None:
        """Set the next step from how hard this increment was."""
        if iterations > self.relaxer.hard:
            self.step = max(SHRINK * length, SHORT_STEP * self.max_step)
        elif iterations <= self.relaxer.easy and length > 0.5 * self.step:
            self.step = min(GROW * self.step, self.max_step)

    # -- stability

    def settle_down(self, solution: Solution, *, smooth: bool) -> Increment:
        """Count the unstable modes; where there are any, kick and descend until there are none."""
        state, here = solution.state, analyse(self.system, solution.state)
        iterations, residual = solution.iterations, solution.residual
        amplitude = self.scene.noise.amplitude
        if here.unstable_modes == 0 or amplitude == 0:
            return Increment(state, here, iterations, residual, smooth)
        before = self.system.energy_hat(state)
        unstable = here.unstable_modes
        value = np.nan
        for attempt in range(MOST_KICKS):
            value, kicked = self.kicked(state, amplitude * STRONGER**attempt, attempt)
            solution = self.relax(kicked, descend=True)
            iterations += solution.iterations
            if not solution.converged:
                continue
            here = analyse(self.system, solution.state)
            if here.unstable_modes == 0:
                break
            state = solution.state
        else:
            raise Stuck(
                Outcome.NOT_CONVERGED,
                f"{here.unstable_modes} unstable modes at {state.end_shortening:.6g} are left after "
                f"{MOST_KICKS} kicks: {solution.message}",
            )
        self.tell(
            "instability",
            state.end_shortening,
            before,
            self.system.energy_hat(solution.state),
            f"{unstable} unstable modes, lowest eigenvalue {value:.4g}; kicked along it and descended",
        )
        return Increment(solution.state, here, iterations, solution.residual, smooth=False)

    def kicked(self, state: State, amplitude: float, attempt: int) -> tuple[float, State]:
        """Return the lowest eigenvalue and the state moved along its mode by ``amplitude`` (D).

        The mode's sign is the seed's choice.
        """
        noise = np.random.default_rng([self.scene.noise.seed, self.count, attempt])
        start = noise.standard_normal(state.q.shape)
        value, mode_q, mode_b = lowest_mode(self.system, state, start)
        moved = state.copy()
        moved.q += amplitude * mode_q
        moved.b += amplitude * mode_b
        gap = self.system.wall_gap(state)
        while self.system.wall_gap(moved) < 0.2 * gap:
            amplitude *= 0.5
            moved = state.copy()
            moved.q += amplitude * mode_q
            moved.b += amplitude * mode_b
        return value, moved

    # -- the record

    def accept(self, increment: Increment, *, landing: bool) -> None:
        """Make ``increment`` the present state, and record it."""
        previous = getattr(self, "state", None)
        frame = self.record(increment, landing=landing) if self.recording else None
        self.state = increment.state if frame is None else decode(self.system, frame)
        unchanged = self.state.equals(increment.state)  # always, where K = K0
        self.here = increment.here if unchanged else analyse(self.system, self.state)
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
            converged=True,
            residual=increment.residual,
            iterations=increment.iterations,
            next_step=self.step,
            wall_time=time.perf_counter() - self.clock,
        )
        frame = encode(self.system, increment.state, settled)
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


def outcome_of(solution: Solution) -> Outcome:
    """Return the push's outcome for a relaxation that did not converge."""
    return Outcome.DIVERGED if solution.outcome == "diverged" else Outcome.NOT_CONVERGED


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
        ending = Ending(Outcome.INTERRUPTED, f"interrupted at {where(push):.6g}", where(push))
    except RecordError as error:
        ending = Ending(Outcome.RECORD_FAILED, str(error), where(push))
    for observer in observers:
        observer.finish(ending)
    return ending


def where(push: Push) -> float:
    """Return the end-shortening of the last settled state, nan before the first."""
    state = getattr(push, "state", None)
    return np.nan if state is None else state.end_shortening
