"""The observers of a push that stream it to rerun, by way of a process of its own.

rerun blocks whoever logs to a viewer that has stopped reading, and it may take the process down
with it; so it lives in a child (``derod.views.stream.relay``), and the push only fills a pipe.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from derod.files.outputs import check_output
from derod.pushing.frames import Ending, Event, Frame
from derod.scene import Scene
from derod.terminal import say
from derod.views.stream.messages import Begin, Step
from derod.views.stream.pipe import Pipe
from derod.views.stream.target import Target, parse_target

if TYPE_CHECKING:
    from derod.equilibrium.loop import Report
    from derod.rod.state import State

PATIENCE = {"file": 30.0, "connect": 4.0, "spawn": 6.0, "web": 6.0}
"""Seconds that a place may do nothing at the end of a push before it is given up."""

MOST_STEPS = 400
"""Of one increment's relaxation that are kept; beyond that every other one is."""


class RerunStream:
    """Streams a push to ``target``: "spawn", "connect[=URL]", "web" or "FILE.rrd".

    An existing file is replaced only with ``overwrite``. Raises TargetError, OutputError.
    """

    def __init__(
        self, target: Target | str, color: str = "curvature", *, overwrite: bool = False
    ) -> None:
        self.target = parse_target(target, force=overwrite) if isinstance(target, str) else target
        if self.target.kind == "file":
            check_output(self.target.place, force=self.target.force)
        self.color = color
        self.pipe: Pipe | None = None

    def start(self, scene: Scene, first_increment: int) -> None:
        """Start the process that draws; it gets ready while the push goes on."""
        try:
            self.pipe = Pipe("derod.views.stream.relay")
        except OSError as error:
            _say(f"no process to draw with: {error}; the run goes on unseen")
            return
        self.pipe.send(Begin(self.target, scene, self.color), must=True)

    def event(self, event: Event) -> None:
        """Hand an event on."""
        if self.pipe is not None:
            self.pipe.send(event, must=True)

    def frame(self, frame: Frame) -> None:
        """Hand a frame on."""
        if self.pipe is not None:
            self.pipe.send(frame)

    def step(self, step: Step) -> None:
        """Hand a step of a watched relaxation on."""
        if self.pipe is not None:
            self.pipe.send(step)

    def finish(self, ending: Ending) -> None:
        """Wait for what is under way, as long as it moves; say once what did not arrive."""
        if self.pipe is None:
            return
        pipe, self.pipe = self.pipe, None
        pipe.send(ending, must=True)
        arrived = pipe.drain(PATIENCE[self.target.kind])
        if not arrived and pipe.child.returncode != 1:  # with 1 it has said why
            _say(f"the stream to {self.target} ended early; the run itself is whole")
        elif pipe.dropped:
            _say(f"{pipe.dropped} increments were not shown: {self.target} was too slow")


class RelaxationWatch:
    """Streams the steps inside chosen increments, or inside those with a kick or a snap.

    ``increments`` holds the numbers; None chooses by what happens.
    """

    def __init__(self, stream: RerunStream, increments: frozenset[int] | None) -> None:
        self.stream = stream
        self.increments = increments
        self._begin(-1)
        self._number = 0
        self._unit = 1.0  # K0, of the states' forces

    def _begin(self, increment: int) -> None:
        self._increment = increment
        self._steps: list[dict[str, Any]] = []
        self._every, self._seen = 1, 0
        self._wanted = self.increments is not None

    def start(self, scene: Scene, first_increment: int) -> None:
        """Take the scene's bending stiffness, which states and residuals count in."""
        self._unit = scene.rod.bending

    def relaxation(self, increment: int, iteration: int, state: State, report: Report) -> None:
        """One step of a relaxation toward ``increment``."""
        if increment != self._increment:
            self._begin(increment)
        if self.increments is not None and increment not in self.increments:
            return
        self._seen += 1
        if (self._seen - 1) % self._every:
            return
        self._steps.append(
            {
                "increment": increment,
                "end_shortening": state.end_shortening,
                "residual": report.residual * self._unit,
                "positions": state.positions,
                "drop_center": state.drop_center,
                "edge_tension": state.edge_tension * self._unit,
                "menisci": state.menisci,
                "forces": tuple(force * self._unit for force in state.forces),
                "holonomy": state.holonomy,
            }
        )
        if len(self._steps) > MOST_STEPS:
            self._steps = self._steps[::2]
            self._every *= 2

    def event(self, event: Event) -> None:
        """A kick or a snap makes the increment worth watching."""
        if event.kind in ("instability", "snap"):
            self._wanted = True

    def frame(self, frame: Frame) -> None:
        """The increment is settled: show how, if it was to be watched."""
        self._show()

    def finish(self, ending: Ending) -> None:
        """Show the last increment, also if it never settled."""
        if ending.outcome in ("not_converged", "diverged", "out_of_balance"):
            self._wanted = True
        self._show()

    def _show(self) -> None:
        if self._wanted:
            for step in self._steps:
                self.stream.step(Step(number=self._number, **step))
                self._number += 1
        self._begin(-1)


def _say(text: str) -> None:
    say(f"derod: rerun: {text}")
