"""Observers kept at arm's length: what they do can neither end nor fail the push they watch."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from derod.pushing.frames import Ending, Event, Frame, Observer, RelaxationObserver
from derod.terminal import say

if TYPE_CHECKING:
    from derod.equilibrium.loop import Report
    from derod.rod.state import State
    from derod.scene import Scene


class Guarded:
    """An observer that is dropped, with a remark, when it raises; it sees read-only frames."""

    def __init__(self, observer: Observer) -> None:
        self.observer = observer
        self.error: Exception | None = None

    def start(self, scene: Scene, first_increment: int) -> None:
        """Hand on that the push begins."""
        self._tell("start", scene, first_increment)

    def event(self, event: Event) -> None:
        """Hand on an event."""
        self._tell("event", event)

    def frame(self, frame: Frame) -> None:
        """Hand on a frame."""
        if self.error is None:
            self._tell("frame", read_only(frame))

    def finish(self, ending: Ending) -> None:
        """Hand on the ending, also to one that has raised: it may have something to close."""
        failed = self.error is not None
        self.error = None
        self._tell("finish", ending, silent=failed)

    def _tell(self, name: str, *arguments: Any, silent: bool = False) -> None:
        if self.error is not None:
            return
        try:
            getattr(self.observer, name)(*arguments)
        except Exception as error:
            self.error = error
            if not silent:
                who = type(self.observer).__name__
                say(
                    f"derod: {who}.{name} failed with {type(error).__name__}: {error}; "
                    "the push goes on without it"
                )


class GuardedWatcher(Guarded):
    """One that also watches the steps inside an increment."""

    def relaxation(self, increment: int, iteration: int, state: State, report: Report) -> None:
        """Hand on a step."""
        self._tell("relaxation", increment, iteration, state, report)


def guarded(observers: Sequence[Observer]) -> list[Guarded]:
    """All of them, guarded."""
    return [
        GuardedWatcher(one) if isinstance(one, RelaxationObserver) else Guarded(one)
        for one in observers
    ]


def read_only(frame: Frame) -> Frame:
    """The frame as others may see it: the push goes on from the arrays themselves."""
    return Frame(
        frame.row.copy(),
        _view(frame.positions),
        _view(frame.arc_length),
        _view(frame.drop_center),
        _view(frame.edge_tension),
        None if frame.edge_frame is None else _view(frame.edge_frame),
    )


def _view(array: np.ndarray) -> np.ndarray:
    view = array.view()
    view.flags.writeable = False
    return view
