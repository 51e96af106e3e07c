"""A diagram in memory: plain tables and fields, in the units of files."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from derod.diagram.layout import POINT, SPECIAL
from derod.equilibrium.system import System
from derod.pushing.columns import Settled
from derod.pushing.encode import encode
from derod.pushing.frames import Frame
from derod.pushing.rows import ROW
from derod.tracing.arc import Point
from derod.tracing.path import Path
from derod.tracing.special import Special
from derod.tracing.symmetry import character, node_weights


@dataclass
class StoredPath:
    """One path."""

    name: str
    table: np.ndarray  # (n,) of POINT
    specials: np.ndarray  # (k,) of SPECIAL
    positions: np.ndarray  # (n, N+1, 3), D
    arc_length: np.ndarray  # (n, N+1), D
    edge_tension: np.ndarray  # (n, N), K0/D^2
    drop_center: np.ndarray  # (n, 3), D
    begins: str = ""
    ends: str = ""
    character: str = ""
    """Which symmetries the state at its middle has."""
    whole: bool = True

    def __len__(self) -> int:
        return len(self.table)

    def frame(self, i: int) -> Frame:
        """Return point i as the frame of a run."""
        return Frame(
            self.table[i], self.positions[i], self.arc_length[i], self.drop_center[i],
            self.edge_tension[i],
        )  # fmt: skip


@dataclass
class Diagram:
    """Paths of one scene in one control."""

    scene_text: str
    control: str
    command: str = "{}"
    stages: tuple[str, ...] = ()
    complete: bool = False
    slides: bool = False
    paths: dict[str, StoredPath] = field(default_factory=dict)


def stored(system: System, path: Path, unit: float) -> StoredPath:
    """Return a traced path as it is kept; ``unit`` turns the control's value into that of files."""
    frames = [framed(system, i, point) for i, point in enumerate(path.points)]
    table = np.zeros(len(frames), POINT)
    for row, frame, point in zip(table, frames, path.points, strict=True):
        for name in ROW.names or ():
            row[name] = frame.row[name]
        row["path_arc"], row["path_rate"] = point.arc, point.rate * unit
    middle = path.points[len(path.points) // 2].state
    weight = node_weights(system.rest_lengths(middle))
    return StoredPath(
        path.name,
        table,
        special_table(path, system, unit),
        np.array([frame.positions for frame in frames]),
        np.array([frame.arc_length for frame in frames]),
        np.array([frame.edge_tension for frame in frames]),
        np.array([frame.drop_center for frame in frames]),
        path.begins, path.ends, character(middle, weight), path.whole,
    )  # fmt: skip


def framed(system: System, i: int, point: Point) -> Frame:
    """Return a point of a path as a frame."""
    settled = Settled(i, 0, True, False, point.here.residual, 0.0, point.iterations, 0.0, 0.0)
    return encode(system, point.here, settled)


def special_table(path: Path, system: System, unit: float) -> np.ndarray:
    """Return the special points of a path, (k,) of SPECIAL."""
    return np.array([special_row(path, one, system, unit) for one in path.specials], SPECIAL)


def special_row(path: Path, special: Special, system: System, unit: float) -> tuple[Any, ...]:
    """Return a special point as a row of SPECIAL."""
    here, k = special.point.here, system.bending
    arcs = np.array([point.arc for point in path.points])
    index = max(0, int(np.searchsorted(arcs, special.arc)) - 1)
    shortening = here.state.end_shortening
    if shortening == here.control_value:  # the control itself
        shortening = special.value
    return (
        special.kind.encode(), index, special.arc, special.value * unit, shortening,
        here.tension * k, here.energy_hat * k, special.change, special.eigenvalue * k,
        special.error * unit, special.symmetric, special.fate.encode(), special.partner.encode(),
    )  # fmt: skip
