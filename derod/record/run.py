"""What every run offers to its readers, wherever its frames are kept."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import TYPE_CHECKING, Any, Self

import numpy as np

from derod.pushing.frames import Ending, Event, Frame, Outcome
from derod.record import layout
from derod.scene import Scene

if TYPE_CHECKING:
    from derod.record.si import SIReading
    from derod.views.plots.picture import Picture


class BaseRun(ABC):
    """The frames of a push. Lengths are in D, forces in K0/D^2, energies in K0/D, angles in rad.

    Increments may be negative, to count from the last; those that are not there raise IndexError.
    """

    path: str | None
    created: str | None

    @property
    @abstractmethod
    def scene(self) -> Scene:
        """The scene as it was run, with what the command line changed."""

    @property
    @abstractmethod
    def table(self) -> np.ndarray:
        """One row of dtype ``frames.ROW`` for each settled increment, (T,)."""

    @property
    @abstractmethod
    def events(self) -> tuple[Event, ...]:
        """What happened between the frames, in order."""

    @property
    @abstractmethod
    def ending(self) -> Ending | None:
        """How the push ended; None while it goes on, and for good if it was killed."""

    @property
    @abstractmethod
    def extrapolated(self) -> np.ndarray | None:
        """The rows of ``derod.record.extrapolate`` kept with the run; None where it was not extrapolated."""

    @abstractmethod
    def field(self, name: str, i: int) -> np.ndarray:
        """The array of increment ``i`` (not negative) that the layout calls ``name``."""

    @property
    def outcome(self) -> Outcome | None:
        """``ending.outcome``, or None."""
        return None if self.ending is None else self.ending.outcome

    @property
    def si(self) -> SIReading:
        """The run in SI; raises SceneError where its scene has no [material]."""
        from derod.record.si import SIReading

        return SIReading(self)

    def __len__(self) -> int:
        """The number of settled increments."""
        return len(self.table)

    def positions(self, i: int) -> np.ndarray:
        """Nodes of increment ``i``, (N+1, 3), D."""
        return self.field(layout.POSITION, self.index(i))

    def arc_length(self, i: int) -> np.ndarray:
        """Arc length of the nodes of increment ``i``, (N+1,), D."""
        return self.field(layout.ARC_LENGTH, self.index(i))

    def edge_tension(self, i: int) -> np.ndarray:
        """Tension in the edges of increment ``i``, (N,), K0/D^2."""
        return self.field(layout.EDGE_TENSION, self.index(i))

    def drop_center(self, i: int) -> np.ndarray:
        """Centre of the drop at increment ``i``, (3,), D."""
        return self.field(layout.DROP, self.index(i)).reshape(3)

    def frame_at(self, i: int) -> Frame:
        """All of increment ``i``."""
        i = self.index(i)
        return Frame(
            row=self.table[i],
            positions=self.positions(i),
            arc_length=self.arc_length(i),
            drop_center=self.drop_center(i),
            edge_tension=self.edge_tension(i),
        )

    def plot(self, kind: str = "path", *others: Any, **options: Any) -> Picture:
        """Draw the run, with ``others`` (runs, branch files) beside it; see ``derod.views.plots.plot``."""
        from derod.views.plots import plot

        return plot(kind, [self, *others], **options)

    def refresh(self) -> Self:
        """Take in what was recorded since; returns the run itself."""
        return self

    def close(self) -> None:  # noqa: B027  nothing to let go of in memory
        """Let go of the file."""

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def index(self, i: int) -> int:
        """``i`` counted from the first increment; raises IndexError."""
        count = len(self)
        if not -count <= i < count:
            raise IndexError(f"increment {i} of a run with {count}")
        return int(i) % count
