"""Run and branch files as the figures want them."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

import derod
from derod.scene.axis import END_SHORTENING, axes_of, axis_of
from derod.views import file_kinds as kinds
from derod.views.plots.style import LABELS

HARD_WALL = 2.0  # the plateau of the hard-wall limit is f_gamma - 2, K0/D^2


@dataclass
class Files:
    """What the command line named: runs and branch files, open."""

    runs: list[Any] = field(default_factory=list)
    branches: list[Any] = field(default_factory=list)
    sweeps: list[Any] = field(default_factory=list)

    def __enter__(self) -> Files:
        return self

    def __exit__(self, *_: object) -> None:
        for file in (*self.runs, *self.branches, *self.sweeps):
            file.close()


def open_files(paths: Iterable[str]) -> Files:
    """Open run files, branch files and sweeps, told apart by what they are. Raises derod.RecordError."""
    files = Files()
    for path in paths:
        kinds.expect(path, kinds.TABLES)
        if kinds.kind_of(path) is kinds.Kind.BRANCHES:
            files.branches.append(derod.open_branches(path))
        elif kinds.kind_of(path) is kinds.Kind.SWEEP:
            files.sweeps.append(derod.open_sweep(path))
        else:
            files.runs.append(derod.open_run(path))
    return files


@dataclass(frozen=True)
class Shape:
    """One configuration: nodes (k, 3), their arc length (k,), the drop and the menisci, D.

    Without a drop its centre and the menisci are nan.
    """

    positions: np.ndarray
    arc_length: np.ndarray
    drop_center: np.ndarray
    menisci: tuple[float, float]
    end_shortening: float
    end_tension: float
    energy_hat: float
    name: str = ""
    wall: float = float("nan")  # distance from the drop's centre at which the soft wall is singular

    @property
    def wet(self) -> bool:
        """Whether there is a drop."""
        return bool(np.isfinite(self.drop_center).all())

    @property
    def center(self) -> np.ndarray:
        """The drop's centre (3,), or the middle between the clamps, D."""
        if self.wet:
            return self.drop_center
        return np.asarray(0.5 * (self.positions[0] + self.positions[-1]))

    @property
    def coiled(self) -> np.ndarray:
        """Which nodes (k,) lie in the drop; all of them without one."""
        if not self.wet:
            return np.ones(self.arc_length.size, dtype=bool)
        return (self.arc_length > self.menisci[0]) & (self.arc_length < self.menisci[1])


def run_shape(run: Any, end_shortening: float) -> Shape:
    """The increment of a run nearest to an end-shortening (D)."""
    i = int(np.argmin(abs(run.table["end_shortening"] - end_shortening)))
    return run_shape_at(run, i)


def run_shape_at(run: Any, i: int) -> Shape:
    """Increment ``i`` of a run."""
    row = run.table[i]
    return Shape(
        run.positions(i),
        run.arc_length(i),
        run.drop_center(i),
        (float(row["meniscus_a"]), float(row["meniscus_b"])),
        float(row["end_shortening"]),
        float(row["end_tension"]),
        float(row["energy_hat"]),
        wall=float("nan") if run.scene.drop is None else 0.5 * (1 + run.scene.drop.wall_softness),
    )


def branch_shape(branch: Any, end_shortening: float) -> Shape:
    """The point of a branch nearest to an end-shortening (D), of lowest energy among equals."""
    table = branch.table
    distance = abs(table["end_shortening"] - end_shortening)
    near = np.flatnonzero(distance < distance.min() + 0.05)
    i = int(near[np.argmin(table["energy_hat"][near])])
    return branch_shape_at(branch, i)


def branch_shape_at(branch: Any, i: int) -> Shape:
    """Point ``i`` of a branch."""
    row = branch.table[i]
    s = branch.arc_length(i)
    middle, half = 0.5 * s[-1], 0.5 * row["wetted_length"]
    return Shape(
        branch.positions(i),
        s,
        branch.drop_center(i),
        (middle - half, middle + half),
        float(row["end_shortening"]),
        float(row["end_tension"]),
        float(row["energy_hat"]),
        branch.name,
        0.5 * (1 + branch.parameters.wall_softness),
    )


def landing_shapes(branch: Any, end_shortening: float) -> list[Shape]:
    """The states of a branch at an end-shortening (D), solved there; none where it has none."""
    from derod.branches import LandingError, center_line

    try:
        found = branch.at(end_shortening)
    except LandingError:
        return []
    out = []
    for landing in found:
        values, length = landing.values, branch.parameters.length
        s = branch.arc_length(landing.interval)
        middle, half = 0.5 * length, 0.5 * values["wetted_length"]
        center = np.array([0.0, values["drop_y"], 0.5 * (length - values["end_shortening"])])
        out.append(
            Shape(
                center_line(landing.state, s),
                s,
                center,
                (middle - half, middle + half),
                values["end_shortening"],
                values["end_tension"],
                values["energy_hat"],
                branch.name,
                0.5 * (1 + branch.parameters.wall_softness),
            )
        )
    return out


def label(file: Any) -> str:
    """What a legend calls a run or a branch file: the file's name without its ending."""
    return Path(file.path).stem if file.path else "in memory"


def abscissa(run: Any) -> tuple[np.ndarray, str]:
    """What a run is drawn against (T,), and its label: what drives it, or increments where it turns back."""
    axis = axis_of(run.scene)
    values = run.table[axis.column]
    if len(axes_of(run.scene)) > 1:
        return np.arange(len(values), dtype=float), "increment"
    if np.all(np.diff(values) >= 0) or np.all(np.diff(values) <= 0):
        label = LABELS["delta"] if axis is END_SHORTENING else f"{axis.name}   ({axis.unit})"
        return values / np.pi if axis.in_pi else values, label
    return np.arange(len(values), dtype=float), LABELS["increment"]


def event_row(run: Any, event: Any) -> int:
    """The increment at which an event is drawn: the one after it, for turning points the one before."""
    i = event.increment - (event.kind == "turn")
    return int(np.clip(i, 0, len(run) - 1))


def stretches(
    flags: Sequence[bool] | np.ndarray, neutral: Sequence[int] | np.ndarray = ()
) -> list[tuple[int, int, bool]]:
    """Stretches (first, last, flag) of a path; neighbours share a point.

    The piece between two points has the flag if both have it. Points that are ``neutral``, where
    the flag changes (bifurcations), have no say.
    """
    flags = np.asarray(flags, dtype=bool)
    if flags.size < 2:
        return []
    lenient = flags.copy()
    lenient[np.asarray(neutral, dtype=int)] = True
    both_neutral = np.zeros(flags.size, dtype=bool)
    both_neutral[np.asarray(neutral, dtype=int)] = True
    pieces = np.where(
        both_neutral[:-1] & both_neutral[1:], flags[:-1] & flags[1:], lenient[:-1] & lenient[1:]
    )
    edges = [0, *(np.flatnonzero(np.diff(pieces)) + 1), pieces.size]
    return [(int(a), int(b), bool(pieces[a])) for a, b in pairwise(edges)]


def flatness(positions: np.ndarray) -> float:
    """How far a curve (N+1, 3) is from a plane through the clamps' axis: least spread over
    length.
    """
    from_axis = positions[:, :2]
    return float(np.linalg.svd(from_axis, compute_uv=False)[-1] / np.sqrt(len(positions)))


def planar_intervals(run: Any, limit: float = 1e-3) -> list[tuple[float, float]]:
    """End-shortenings (first, last), D, of the stretches of increments that lie in a plane."""
    delta = run.table["end_shortening"]
    flat = np.array([flatness(run.positions(i)) < limit for i in range(len(run))])
    found = []
    i = 0
    while i < len(flat):
        if flat[i]:
            j = i
            while j + 1 < len(flat) and flat[j + 1]:
                j += 1
            found.append((float(delta[i]), float(delta[j])))
            i = j
        i += 1
    return found
