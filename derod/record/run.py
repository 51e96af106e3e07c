"""What every run offers to its readers, wherever its frames are kept."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any, Self, overload

import numpy as np

from derod.pushing.frames import Ending, Event, Frame, Outcome
from derod.record import layout
from derod.record.increment import Increment, nearest
from derod.scene import Scene

if TYPE_CHECKING:
    from derod.record.geometry import MaterialFrame
    from derod.record.kicked import Kicked
    from derod.record.modes import Modes
    from derod.record.sensitivities import Sensitivities
    from derod.record.si import SIReading
    from derod.views.plots.picture import Picture


class BaseRun(ABC):
    """The frames of a push. Lengths are in D, forces in K0/D^2, energies in K0/D, angles in rad.

    Increments may be negative, to count from the last; those that are not there raise IndexError.
    ``run[i]`` is an ``Increment``, ``run[first:last]`` a list of them, ``run["end_tension"]`` a column of the
    table; a run can be iterated over, while it grows to the increments it had at the beginning.
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

    def edge_frame(self, i: int) -> np.ndarray | None:
        """Frames of the edges of increment ``i``, (N, 7), as ``Frame`` has them; None of a round rod."""
        return self.field(layout.EDGE_FRAME, self.index(i)) if self.scene.has_frames else None

    def drop_center(self, i: int) -> np.ndarray:
        """Centre of the drop at increment ``i``, (3,), D."""
        return self.field(layout.DROP, self.index(i)).reshape(3)

    @overload
    def __getitem__(self, key: int) -> Increment: ...
    @overload
    def __getitem__(self, key: slice) -> list[Increment]: ...
    @overload
    def __getitem__(self, key: str) -> np.ndarray: ...
    def __getitem__(self, key: int | slice | str) -> Increment | list[Increment] | np.ndarray:
        """An increment by its number, several by a slice, or a column of the table by its name."""
        if isinstance(key, str):
            if key not in (self.table.dtype.names or ()):
                names = ", ".join(self.table.dtype.names or ())
                raise KeyError(f"no column {key!r}; allowed: {names}")
            column: np.ndarray = self.table[key]
            return column
        if isinstance(key, slice):
            return [Increment(self, i) for i in range(*key.indices(len(self)))]
        return Increment(self, self.index(key))

    def __iter__(self) -> Iterator[Increment]:
        """The increments, in order."""
        return (Increment(self, i) for i in range(len(self)))

    def at(self, place: float | str, column: str | None = None) -> Increment:
        """The increment nearest to an end-shortening: ``run.at("1.5 pi")``, ``run.at(4.7)`` (D).

        Where another control pushes first, to a value of that; ``column`` names another one, such as
        "end_shortening". The first of them where the push passed the place again. Raises ValueError for what
        is no number, IndexError for a place outside the run.
        """
        return Increment(self, nearest(self, place, column))

    def curvature(self, i: int) -> np.ndarray:
        """Curvature at the nodes of increment ``i``, (N+1,), 1/D: turning angle over dual length.

        Of second order in the edge length.
        """
        from derod.record import fields

        return fields.curvature(self, i)

    def moment(self, i: int) -> np.ndarray:
        """Moment in the rod at the nodes of increment ``i``, (N+1, 3), K0/D, in space.

        m = K kappa b + k3 u3 d3, with the curvature's binormal b and the twist u3 = (R - psi)/l. Of second
        order in the edge length; the recorded tensions and energies are of fourth.
        """
        from derod.record import fields

        return fields.moment(self, i)

    def directors(self, i: int) -> MaterialFrame:
        """The material frame at the nodes of increment ``i``: unit vectors d1, d2, d3, each (N+1, 3).

        Parallel transport of e_x from the start clamp, turned by u3 s about the tangent d3; it ends as
        the end clamp's frame, turned by ``end_rotation``.
        """
        from derod.record import fields

        return fields.directors(self, i)

    def wall_pressure(self, i: int) -> np.ndarray:
        """The wall's push toward the drop's centre at the nodes of increment ``i``, (N+1,), K0/D^3.

        A force per unit length, dv/dr = 2 v0/(1 + rho - 2 r)^2 within the drop; zero outside.
        """
        from derod.record import fields

        return fields.wall_pressure(self, i)

    def modes(self, i: int, k: int = 4) -> Modes:
        """The ``k`` softest modes of increment ``i``: eigenvalues (K0/D^4) and shapes, lowest first.

        Of the Hessian on the constraints, turning about the axis, where it is neutral, and sliding of the
        drop left out: as many are negative as the row has ``unstable_modes``. Compiles kernels when they are
        not yet. Raises ``derod.record.modes.ModesError``.
        """
        from derod.record.modes import modes

        return modes(self, self.index(i), k)

    def kick(
        self, i: int, mode: int, amplitude: float = 0.05, found: Modes | None = None
    ) -> Kicked:
        """Move increment ``i`` along its mode number ``mode`` (from 0) by ``amplitude`` (D) and relax it.

        Downhill; the answer says where it went. ``found`` are its modes, if they are known already. Raises
        ``derod.record.modes.ModesError``.
        """
        from derod.record.kicked import kicked

        i = self.index(i)
        return kicked(self, i, self.modes(i, mode + 1) if found is None else found, mode, amplitude)

    def sensitivities(self, i: int) -> Sensitivities:
        """How t, E_hat, menisci, drop and shape of increment ``i`` change with every parameter of the scene.

        Exact derivatives of the discrete rod along its branch, one solve each (implicit function theorem);
        near a fold they are said to be unbounded. ``derod.record.sensitivities.slopes`` gives those of one
        quantity for many increments.
        """
        from derod.record.sensitivities import sensitivities_of

        return sensitivities_of(self, self.index(i))

    def to_pandas(self) -> Any:
        """The table as a pandas.DataFrame, by increment; units in ``.attrs["units"]``.

        Raises ``derod.needs.MissingError`` without pandas.
        """
        from derod.record.tables import to_pandas

        return to_pandas(self)

    def to_xarray(self) -> Any:
        """The table and the fields (increment, node, edge, axis) as an xarray.Dataset, units as attributes.

        Raises ``derod.needs.MissingError`` without xarray.
        """
        from derod.record.tables import to_xarray

        return to_xarray(self)

    def __repr__(self) -> str:
        from derod.views.faces import run_text

        return run_text(self)

    def _repr_html_(self) -> str:
        from derod.views.faces import run_html

        return run_html(self)

    def frame_at(self, i: int) -> Frame:
        """All of increment ``i``."""
        i = self.index(i)
        return Frame(
            row=self.table[i],
            positions=self.positions(i),
            arc_length=self.arc_length(i),
            drop_center=self.drop_center(i),
            edge_tension=self.edge_tension(i),
            edge_frame=self.edge_frame(i),
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
