"""One increment of a run, by itself: ``run[i]``, ``run.at("1.5 pi")``."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from derod.pushing.frames import Frame
from derod.pushing.rows import ROW
from derod.scene.axis import AXES, axis_of
from derod.scene.quantities import read_quantity

if TYPE_CHECKING:
    from derod.record.geometry import MaterialFrame
    from derod.record.modes import Modes
    from derod.record.run import BaseRun
    from derod.record.sensitivities import Sensitivities


class Increment:
    """A settled increment: the fields of its row as attributes, and its arrays, read when asked for.

    ``one.end_tension`` is a number, ``one.positions`` an array; units are those of the run.
    """

    __slots__ = ("index", "run")

    def __init__(self, run: BaseRun, index: int) -> None:
        self.run = run
        self.index = index

    @property
    def row(self) -> np.void:
        """The row of the table, of dtype ``rows.ROW``."""
        row: np.void = self.run.table[self.index]
        return row

    @property
    def frame(self) -> Frame:
        """All that is recorded of it."""
        return self.run.frame_at(self.index)

    @property
    def positions(self) -> np.ndarray:
        """Nodes, (N+1, 3), D."""
        return self.run.positions(self.index)

    @property
    def arc_length(self) -> np.ndarray:
        """Arc length of the nodes, (N+1,), D."""
        return self.run.arc_length(self.index)

    @property
    def edge_tension(self) -> np.ndarray:
        """Tension in the edges, (N,), K0/D^2."""
        return self.run.edge_tension(self.index)

    @property
    def drop_center(self) -> np.ndarray:
        """Centre of the drop, (3,), D."""
        return self.run.drop_center(self.index)

    @property
    def curvature(self) -> np.ndarray:
        """Curvature at the nodes, (N+1,), 1/D."""
        return self.run.curvature(self.index)

    @property
    def moment(self) -> np.ndarray:
        """Moment at the nodes, (N+1, 3), K0/D."""
        return self.run.moment(self.index)

    @property
    def directors(self) -> MaterialFrame:
        """The material frame at the nodes: d1, d2, d3, each (N+1, 3)."""
        return self.run.directors(self.index)

    @property
    def wall_pressure(self) -> np.ndarray:
        """The wall's push on the wetted nodes, (N+1,), K0/D^3."""
        return self.run.wall_pressure(self.index)

    def modes(self, k: int = 4) -> Modes:
        """The k softest modes; see ``BaseRun.modes``."""
        return self.run.modes(self.index, k)

    def sensitivities(self) -> Sensitivities:
        """How it changes with every parameter; see ``BaseRun.sensitivities``."""
        return self.run.sensitivities(self.index)

    def __getattr__(self, name: str) -> Any:
        if name in (ROW.names or ()):
            return self.row[name].item()
        raise AttributeError(
            f"an increment has no {name!r}; its row has {', '.join(ROW.names or ())}"
        )

    def __dir__(self) -> list[str]:
        return sorted({*super().__dir__(), *(ROW.names or ())})

    def __repr__(self) -> str:
        row = self.row
        axis = axis_of(self.run.scene, int(row["segment"]))
        modes = int(row["unstable_modes"])
        return (
            f"<increment {self.index} of {len(self.run)}: {axis.name} "
            f"{axis.both(float(row[axis.column]))}, t = {row['end_tension']:.6g} K0/D^2, "
            f"E_hat = {row['energy_hat']:.6g} K0/D, "
            + ("stable>" if modes == 0 else f"{modes} unstable modes>")
        )

    def _repr_html_(self) -> str:
        from derod.record import layout
        from derod.scene.html import html_table

        cells = [
            (name, f"{self.row[name]:.8g}" if ROW[name].kind == "f" else str(self.row[name]),
             layout.ROW_UNITS.get(name, ""))
            for name in ROW.names or ()
        ]  # fmt: skip
        return html_table(repr(self)[1:-1], ("", "", "unit"), cells)


def nearest(run: BaseRun, place: float | str, column: str | None = None) -> int:
    """The increment whose driving quantity is nearest to ``place``; see ``BaseRun.at``."""
    if column is not None and column not in AXES:
        raise ValueError(f"column = {column!r}: allowed: {', '.join(AXES)}")
    axis = axis_of(run.scene) if column is None else AXES[column]
    try:
        value = read_quantity(place)
    except ValueError as error:
        raise ValueError(
            f"at {place!r}: {error}; allowed: {axis.name} in {axis.unit}, such as 1.2"
            + (" or '0.5 pi'" if axis.in_pi else "")
        ) from None
    if not len(run):
        raise IndexError(f"at {axis.both(value)}: the run has no increment")
    values = run.table[axis.column]
    low, high = float(values.min()), float(values.max())
    if not low - 1e-9 <= value <= high + 1e-9:
        raise IndexError(
            f"at {axis.both(value)}: the run was not there; allowed: {axis.both(low)} to "
            f"{axis.both(high)}"
        )
    return int(np.argmin(np.abs(values - value)))
