"""The quasi-static push: settle, record, step, leg after leg.

Every increment changes the control, predicts the state along the branch, relaxes it, counts its unstable
modes, and, where there is one, kicks the rod along it and lets it descend (``increments``). The stride
adapts to how hard the last one was. The push goes on from what was recorded, so that a resumed run
follows the same numbers as one that was never stopped.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from derod.algebra import compiling
from derod.equilibrium.measured import Measured
from derod.equilibrium.methods import make_relaxer
from derod.equilibrium.system import System
from derod.errors import RecordError
from derod.pushing import interrupts
from derod.pushing.columns import Settled
from derod.pushing.controls import CONTROLS
from derod.pushing.encode import decode
from derod.pushing.first import first_physics, first_state
from derod.pushing.frames import Ending, Frame, Observer, Outcome
from derod.pushing.increments import OUTER_LEAST, Increment, Increments
from derod.pushing.stride import Stride, same_place
from derod.pushing.stuck import Stuck
from derod.pushing.telling import Telling
from derod.scene import Scene
from derod.scene.controls import HELD
from derod.scene.program import SHORTENING, legs, slides_at_start

if TYPE_CHECKING:
    from derod.record import Run

LEAD_IN = 0.02 * np.pi  # D; a push that starts further in is led there from here
WEIGHT = "weight"
SLACK = 0.001 * np.pi  # D, of the first guess of an end that slides


class Push:
    """One push under way."""

    def __init__(self, scene: Scene, observers: Sequence[Observer]) -> None:
        self.scene = scene
        self.legs = legs(scene)
        self.system = System(scene)
        self.telling = Telling(self.system, observers)
        self.increments = Increments(
            self.system, make_relaxer(scene.relax.method), self.telling, scene.noise
        )
        self.segment = 0
        self.here: Measured | None = None
        self.before: Measured | None = None  # the state before, on the same branch

    # -- the path

    def begin(self) -> None:
        """Settle the first state, led in from a hair's breadth if it lies far in, and record it.

        An upside-down coil is wound without weight, and then loaded.
        """
        push, clamps = self.scene.push, self.scene.clamps
        slides = slides_at_start(self.scene)
        shortens = push.control == SHORTENING
        wanted = push.start if shortens else None if slides else clamps.end_shortening
        near = SLACK if wanted is None else min(wanted, LEAD_IN)
        physics = first_physics(self.system, self.scene, slides)
        weight = physics.weight if push.bend == "up" else 0.0
        self.telling.recording = False
        if shortens:
            self.steer_leg(0)
        else:
            self.steer(SHORTENING, LEAD_IN)
        unloaded = physics._replace(weight=physics.weight - weight)
        first = first_state(self.increments, self.scene, unloaded, near)
        leads = (wanted is not None and near != wanted) or weight != 0
        if not leads and shortens:
            self.telling.recording = True
            self.accept(self.increments.settle_down(first), landing=True)
            return
        if wanted is not None:
            self.accept(self.increments.settle_down(first), landing=False)
            self.advance_to(wanted, ())
        else:
            self.here = first.here
        if weight != 0:
            self.steer(WEIGHT, HELD[WEIGHT].step(self.scene))
            self.remeasure()
            self.advance_to(weight, ())
        if weight != 0 or not shortens:
            self.steer_leg(0)
            self.remeasure()
        self.telling.recording = True
        self.accept(self.increments.settle_down(self.increment_here()), landing=True)

    def begin_again(self, run: Run) -> None:
        """Take up a recorded run after its last frame."""
        frames = [frame_of(run, i) for i in range(max(len(run) - 2, 0), len(run))]
        row = frames[-1].row
        self.segment = int(row["segment"])
        leg = self.legs[self.segment]
        self.steer_leg(self.segment)
        state = decode(self.system, frames[-1], slides=leg.slides)
        if row["smooth"] and len(frames) == 2:
            earlier = decode(self.system, frames[0], slides=leg.slides)
            self.before = self.increments.measure(earlier)
        self.telling.go_on(row, len(run))
        self.here = self.increments.measure(state)
        self.increments.stride.length = float(row["next_step"]) / self.unit

    def run(self) -> Ending:
        """Follow the legs to the last."""
        assert self.here is not None
        for segment in range(self.segment, len(self.legs)):
            leg = self.legs[segment]
            if segment > self.segment:
                self.turn(segment)
            self.advance_to(leg.stop / self.unit, [place / self.unit for place in leg.at])
        words, place = HELD[leg.control].words, self.increments.place(self.value)
        told = place if leg.control != SHORTENING else f"{words} {place}"
        return Ending(Outcome.COMPLETED, f"reached {told}", self.here.state.end_shortening)

    def turn(self, segment: int) -> None:
        """Go over to the next leg: another goal, or another control."""
        assert self.here is not None
        before, leg = self.legs[self.segment], self.legs[segment]
        self.segment = segment
        delta = self.here.state.end_shortening
        if leg.control == before.control:
            value = self.increments.told(self.value)
            self.telling.event("turn", delta, f"turn toward {leg.stop:.6g}", value=value)
            self.increments.stride.largest = leg.max_step / self.unit
            return
        words = HELD[leg.control].words
        self.telling.event("turn", delta, f"from here on the {words} pushes, toward {leg.stop:.6g}")
        self.steer_leg(segment)
        state = self.here.state.copy()
        if leg.slides != before.slides:
            pull = self.here.tension if leg.slides else 0.0
            state.physics = state.physics._replace(slides=leg.slides, end_tension=pull)
        self.before = None
        self.here = self.increments.measure(state)
        settled = self.increments.settle_down(self.increment_here())
        if settled.here is not self.here:
            self.accept(settled, landing=False)

    def steer_leg(self, segment: int) -> None:
        """Push with the control of a leg from here on."""
        leg = self.legs[segment]
        self.steer(leg.control, leg.max_step, leg.locate)

    def steer(self, name: str, max_step: float, locate: bool = False) -> None:
        """Push with a control from here on; with ``locate``, look for events between increments."""
        usual = HELD[name].step(self.scene)
        self.increments.control = CONTROLS[name]
        self.increments.words = HELD[name].words
        self.increments.locates = locate
        self.increments.stride = Stride(max_step / self.unit, usual / self.unit)

    def advance_to(self, stop: float, landings: Sequence[float]) -> None:
        """Push to ``stop``, landing on the way on every one of ``landings`` exactly."""
        while not same_place(self.value, stop):
            here = self.value
            low, high = min(here, stop), max(here, stop)
            ahead = [x for x in landings if low < x < high and not same_place(x, here)]
            goal = (min(ahead) if stop > here else max(ahead)) if ahead else stop
            self.advance(goal)

    def advance(self, goal: float) -> None:
        """Settle and record one increment toward ``goal``, halving it until it converges."""
        while True:
            assert self.here is not None
            target = self.increments.stride.target(self.value, goal)
            increment = self.increments.attempt(self.here, self.before, target)
            if increment is not None:
                self.accept(increment, landing=target == goal)
                return

    # -- the present state

    @property
    def value(self) -> float:
        """Return the control's value, in the rod's units."""
        assert self.here is not None
        return self.here.control_value

    @property
    def unit(self) -> float:
        """Return what turns the control's value into that of files."""
        return self.increments.unit

    def accept(self, increment: Increment, *, landing: bool) -> None:
        """Make ``increment`` the present state, and record it."""
        previous = self.here
        here = increment.here
        if self.telling.recording:
            frame = self.telling.frame(here, self.row_of(increment, landing))
            if self.system.bending != 1:  # rounded by the change of units; else exactly what it is
                state = decode(self.system, frame, slides=here.state.physics.slides)
                here = here if state.equals(here.state) else self.increments.measure(state)
        self.here = here
        self.before = previous if increment.smooth else None
        if self.system.outer_length(here.state) < OUTER_LEAST:
            place = self.increments.place(self.value)
            raise Stuck(Outcome.ROD_RAN_OUT, f"the outer rod ran out at {place}")

    def row_of(self, increment: Increment, landing: bool) -> Settled:
        """Return what the row says of how the increment was settled."""
        return Settled(
            increment=self.telling.count,
            segment=self.segment,
            smooth=increment.smooth,
            landing=landing,
            residual=increment.residual,
            work_defect=increment.defect,
            iterations=increment.iterations,
            next_step=self.increments.stride.length * self.unit,
            wall_time=self.telling.elapsed(),
        )

    def remeasure(self) -> None:
        """Measure the present state along the present control."""
        assert self.here is not None
        self.here = self.increments.measure(self.here.state)

    def increment_here(self) -> Increment:
        """Return the present state as an increment."""
        assert self.here is not None
        return Increment(self.here, 0, self.here.residual, smooth=False)


def frame_of(run: Run, i: int) -> Frame:
    """Return a recorded frame."""
    return run.frame_at(i)


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
            observer.start(scene, push.telling.count)
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
    ending = replace(ending, compiling=compiling.take())
    for observer in observers:
        observer.finish(ending)
    return ending


def where(push: Push) -> float:
    """Return the end-shortening of the last settled state, nan before the first."""
    return np.nan if push.here is None else push.here.state.end_shortening
