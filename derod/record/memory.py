"""A run that lives in memory only."""

from __future__ import annotations

import numpy as np

from derod.errors import RecordError
from derod.pushing.frames import Ending, Event, Frame
from derod.pushing.rows import ROW
from derod.record import layout
from derod.record.run import BaseRun
from derod.scene import Scene

ATTRIBUTES = {
    layout.POSITION: "positions",
    layout.ARC_LENGTH: "arc_length",
    layout.EDGE_TENSION: "edge_tension",
    layout.EDGE_FRAME: "edge_frame",
    layout.DROP: "drop_center",
}
"""Where a Frame keeps what the layout of a file calls by these names."""


class MemoryRun(BaseRun):
    """A run kept in memory: an observer of a push with the interface of a run file."""

    def __init__(self) -> None:
        self.path = None
        self.created = None
        self._frames: list[Frame] = []
        self._events: list[Event] = []
        self._ending: Ending | None = None
        self._scene: Scene | None = None
        self._table: np.ndarray | None = None
        self._extrapolated: np.ndarray | None = None

    @property
    def scene(self) -> Scene:
        """The scene as it was run."""
        if self._scene is None:
            raise RecordError("the push has not begun")
        return self._scene

    @property
    def table(self) -> np.ndarray:
        """One row for each settled increment, (T,), read-only."""
        if self._table is None:
            self._table = np.array([frame.row for frame in self._frames], dtype=ROW)
            self._table.flags.writeable = False
        return self._table

    @property
    def events(self) -> tuple[Event, ...]:
        """What happened between the frames."""
        return tuple(self._events)

    @property
    def ending(self) -> Ending | None:
        """How the push ended, or None."""
        return self._ending

    @property
    def extrapolated(self) -> np.ndarray | None:
        """The rows of ``derod.record.extrapolate``, or None."""
        return self._extrapolated

    def keep_extrapolated(self, table: np.ndarray) -> None:
        """Keep the rows of ``derod.record.extrapolate``."""
        self._extrapolated = table

    def __len__(self) -> int:
        return len(self._frames)

    def start(self, scene: Scene, first_increment: int) -> None:
        """Begin, or go on after the frames that are here already."""
        if first_increment != len(self._frames):
            raise RecordError(
                f"the push goes on at increment {first_increment}, but {len(self)} are in memory"
            )
        self._scene, self._ending = scene, None

    def event(self, event: Event) -> None:
        """Keep ``event``."""
        self._events.append(event)

    def frame(self, frame: Frame) -> None:
        """Keep a copy of ``frame``."""
        self._frames.append(copied(frame))
        self._table = None

    def finish(self, ending: Ending) -> None:
        """Keep ``ending``."""
        self._ending = ending

    def field(self, name: str, i: int) -> np.ndarray:
        """The array of increment ``i`` that the layout calls ``name``."""
        return getattr(self._frames[i], ATTRIBUTES[name]).copy()


def copied(frame: Frame) -> Frame:
    """A frame whose arrays are its own: the push may use its arrays again."""
    return Frame(
        row=frame.row.copy(),
        positions=frame.positions.copy(),
        arc_length=frame.arc_length.copy(),
        drop_center=frame.drop_center.copy(),
        edge_tension=frame.edge_tension.copy(),
        edge_frame=None if frame.edge_frame is None else frame.edge_frame.copy(),
    )
