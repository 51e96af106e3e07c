"""Branch files (HDF5): one group a branch, everything needed to draw it, compare with it, restart
from it.

Layout: attributes ``format``, ``parameters`` (one dataset of the dimensionless numbers),
``scene`` (its text); ``branches/NAME`` with ``table`` (one row a point), ``nodes`` and ``eta``
(the half rod's node states and element lengths of all points, one after another) and
``bifurcations``. Written to a temporary name and moved into place, so that a file is complete or
absent.
"""

from __future__ import annotations

from dataclasses import asdict, fields
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING

import h5py
import numpy as np

from derod.branches.element import moment, quaternion_rate, tangent
from derod.branches.gauss import NODES, STAGES
from derod.branches.parameters import Parameters
from derod.branches.state import HalfRod
from derod.errors import RecordError

if TYPE_CHECKING:
    from derod.branches.branch import Branch

FORMAT = "derod-branches-1"
POINT = np.dtype(
    [
        ("end_shortening", "f8"),  # delta, D
        ("end_tension", "f8"),  # t, K0/D^2
        ("energy_hat", "f8"),  # E_tot + f_gamma (delta + 1), K0/D
        ("energy_total", "f8"),
        ("energy_bend", "f8"),
        ("energy_twist", "f8"),
        ("energy_wall", "f8"),
        ("wetted_length", "f8"),  # 2 sigma, D
        ("meniscus_force", "f8"),  # f_B, K0/D^2
        ("drop_y", "f8"),  # y_C from the clamp axis, D
        ("wall_gap", "f8"),  # least 1 + rho - 2 r
        ("error", "f8"),  # mesh halving: t, E_hat (relative), wetted length
        ("unstable_modes", "i4"),  # -1: not counted
        ("elements", "i4"),
        ("inner", "i4"),  # of them in the drop
        ("scalars", "f8", (6,)),  # c_x, c_z, u3, sigma, delta, f_gamma
    ]
)
"""One row of a branch's table."""

BIFURCATION = np.dtype(
    [
        ("kind", "S16"),
        ("index", "i8"),  # row of the table
        ("end_shortening", "f8"),
        ("end_tension", "f8"),
        ("energy_hat", "f8"),
        ("partner", "S32"),  # the branch that joins here, "" where none was followed
        ("test_function", "f8"),  # what is left of it, relative to its bracket
    ]
)


SCALED = (
    "end_tension",
    "energy_hat",
    "energy_total",
    "energy_bend",
    "energy_twist",
    "energy_wall",
    "meniscus_force",
)
"""Columns multiplied by K/K0, so that files are in units of K0 as run files are."""


def write_branches(
    path: str | Path, parameters: Parameters, branches: list[Branch], scene_text: str = ""
) -> None:
    """Write branches to a new file (replaced only when the new one is complete)."""
    target = Path(path)
    partial = target.with_name(target.name + ".part")
    try:
        with h5py.File(partial, "w", libver=("v110", "v110")) as file:
            file.attrs["format"] = FORMAT
            file.attrs["units"] = "lengths D, forces K0/D^2, energies K0/D, angles radians"
            file.attrs["scene"] = scene_text
            for name, value in asdict(parameters).items():
                file.attrs[name] = value
            root = file.create_group("branches", track_order=True)
            for branch in branches:
                _write_branch(root.create_group(branch.name), branch)
        partial.replace(target)
    finally:
        partial.unlink(missing_ok=True)


def _write_branch(group: h5py.Group, branch: Branch) -> None:
    table = np.zeros(len(branch.points), POINT)
    for row, point in zip(table, branch.points, strict=True):
        for name, value in point.values.items():
            row[name] = value
        for name in SCALED:
            row[name] *= point.state.parameters.bending
        row["error"] = point.error
        row["unstable_modes"] = point.unstable_modes
        row["elements"] = point.state.eta.size
        row["inner"] = point.state.inner
        row["scalars"] = point.state.scalars
    bifurcations = np.zeros(len(branch.bifurcations), BIFURCATION)
    for row, special in zip(bifurcations, branch.bifurcations, strict=True):
        at = table[special.index]
        row["kind"], row["index"], row["partner"] = special.kind, special.index, special.partner
        for name in ("end_shortening", "end_tension", "energy_hat"):
            row[name] = at[name]
        row["test_function"] = special.function
    group.attrs["begins"] = branch.begins
    group.attrs["ends"] = branch.ends
    group.attrs["remarks"] = "\n".join(branch.remarks)
    group.attrs["mirror"] = branch.even.name
    group["table"] = table
    group["bifurcations"] = bifurcations
    group["nodes"] = np.concatenate([p.state.nodes for p in branch.points])
    group["eta"] = np.concatenate([p.state.eta for p in branch.points])


class StoredBranch:
    """One branch of a file. ``table``: structured array (POINT). ``bifurcations``:
    (BIFURCATION)."""

    def __init__(self, name: str, group: h5py.Group, parameters: Parameters) -> None:
        self.name = name
        self.parameters = parameters
        self.table: np.ndarray = group["table"][:]
        self.bifurcations: np.ndarray = group["bifurcations"][:]
        self.begins = str(group.attrs["begins"])
        self.ends = str(group.attrs["ends"])
        self.remarks = str(group.attrs["remarks"]).splitlines()
        self.mirror = str(group.attrs["mirror"])
        self._nodes = group["nodes"][:]
        self._eta = group["eta"][:]
        counts = self.table["elements"].astype(np.int64)
        self._start = np.concatenate([[0], np.cumsum(counts)])

    def __len__(self) -> int:
        return len(self.table)

    def state(self, i: int) -> HalfRod:
        """The half-rod state of point i; its stages are interpolated (settle it before reading t
        or E off it)."""
        i = range(len(self))[i]
        row = self.table[i]
        first, last = self._start[i], self._start[i + 1]
        eta = self._eta[first:last]
        nodes = self._nodes[first + 2 * i : last + 2 * (i + 1)]
        state = HalfRod(
            self.parameters,
            eta,
            int(row["inner"]),
            nodes,
            np.empty((eta.size, STAGES, 4)),
            row["scalars"].copy(),
        )
        state.stages[:] = _stage_guess(state)
        return state

    def half_rod(self, i: int, subdivisions: int = 3) -> tuple[np.ndarray, np.ndarray]:
        """Arc length (k,) from the middle and places w = r - r_C (k, 3) of half a rod, D."""
        state = self.state(i)
        left = np.arange(state.eta.size) + (np.arange(state.eta.size) >= state.inner)
        places = state.nodes[:, :3]
        slopes, bends = _directions(state)
        x = (np.arange(subdivisions) / subdivisions)[None, :, None]
        h = state.lengths[:, None, None]
        value, rate, curvature = places[:, None], slopes[:, None], bends[:, None]
        a, b, c, d, e, f = _quintic(x)
        curve = a * value[left] + h * b * rate[left] + h * h * c * curvature[left]
        right = left + 1
        curve += d * value[right] + h * e * rate[right] + h * h * f * curvature[right]
        nodes = np.delete(state.node_arc_length, state.inner + 1)
        s = nodes[:-1, None] + state.lengths[:, None] * x[0, :, 0]
        return np.append(s, nodes[-1]), np.vstack([curve.reshape(-1, 3), places[-1]])

    def arc_length(self, i: int) -> np.ndarray:
        """Arc length (2k-1,) of ``positions(i)`` from the first clamp, D."""
        s, _ = self.half_rod(i)
        half = 0.5 * self.parameters.length
        return np.concatenate([half - s[::-1], half + s[1:]])

    def positions(self, i: int) -> np.ndarray:
        """Centre line (2k-1, 3) from the clamp at the origin to (0, 0, l - delta), D.

        The second half is computed, the first is its image under the half turn about e_y.
        """
        _, w = self.half_rod(i)
        r = w + np.array([0.0, self.table[i]["drop_y"], 0.0])
        image = r[::-1] * np.array([-1.0, 1.0, -1.0])
        r = np.vstack([image, r[1:]])
        r[:, 2] += 0.5 * (self.parameters.length - self.table[i]["end_shortening"])
        return r

    def drop_center(self, i: int) -> np.ndarray:
        """Centre of the drop (3,) in the frame of ``positions``, D."""
        row = self.table[i]
        return np.array(
            [0.0, row["drop_y"], 0.5 * (self.parameters.length - row["end_shortening"])]
        )


def _quintic(x: np.ndarray) -> tuple[np.ndarray, ...]:
    """Hermite weights at x in [0, 1] of value, slope, curvature at 0, then at 1."""
    y = 1.0 - x
    value = y**3 * (1.0 + 3.0 * x + 6.0 * x * x)
    slope = x * y**3 * (1.0 + 3.0 * x)
    bend = 0.5 * x * x * y**3
    mirrored = x**3 * (1.0 + 3.0 * y + 6.0 * y * y)
    return value, slope, bend, mirrored, -y * x**3 * (1.0 + 3.0 * y), 0.5 * y * y * x**3


def _directions(state: HalfRod) -> tuple[np.ndarray, np.ndarray]:
    """Tangents d_3 and their derivatives m x d_3 at the nodes, each (E+2, 3)."""
    slopes, bends, m = np.empty((len(state.nodes), 3)), np.empty((len(state.nodes), 3)), np.empty(3)
    for y, slope, bend in zip(state.nodes, slopes, bends, strict=True):
        tangent(y[3:7], slope)
        moment(state.scalars[0], state.scalars[1], y[0:3], y[7:10], m)
        bend[:] = np.cross(m, slope)
    return slopes, bends


def _stage_guess(state: HalfRod) -> np.ndarray:
    """Stage quaternions by cubic Hermite interpolation of the node quaternions."""
    prm = state.parameters
    twist = (1.0 - prm.twisting) * state.scalars[2]
    rates = np.empty((len(state.nodes), 4))
    m = np.empty(3)
    for y, rate in zip(state.nodes, rates, strict=True):
        moment(state.scalars[0], state.scalars[1], y[0:3], y[7:10], m)
        quaternion_rate(m, twist, y[3:7], rate)
    left = np.arange(state.eta.size) + (np.arange(state.eta.size) >= state.inner)
    h = state.lengths[:, None, None]
    a, b = state.nodes[left, None, 3:7], state.nodes[left + 1, None, 3:7]
    da, db = rates[left, None], rates[left + 1, None]
    x = NODES[None, :, None]
    out = (1 + 2 * x) * (1 - x) ** 2 * a + x * x * (3 - 2 * x) * b
    out += h * x * (1 - x) * ((1 - x) * da - x * db)
    return np.asarray(out)


class BranchFile:
    """An open branch file: a mapping from names to ``StoredBranch``. Use it as a context or close
    it."""

    def __init__(self, path: str | Path) -> None:
        self.path = Path(path)
        try:
            self._file = h5py.File(self.path, "r")
        except OSError as error:
            raise RecordError(f"{path}: cannot be read as HDF5: {error}") from error
        if self._file.attrs.get("format") != FORMAT:
            self._file.close()
            raise RecordError(f"{path}: not a branch file (format {FORMAT} wanted)")
        attrs = self._file.attrs
        self.parameters = Parameters(**{f.name: float(attrs[f.name]) for f in fields(Parameters)})
        self.scene_text = str(attrs["scene"])
        self.names: list[str] = list(self._file["branches"])
        self._loaded: dict[str, StoredBranch] = {}

    def __getitem__(self, name: str) -> StoredBranch:
        if name not in self.names:
            raise KeyError(f"{self.path}: no branch {name!r}; it has {', '.join(self.names)}")
        if name not in self._loaded:
            self._loaded[name] = StoredBranch(name, self._file["branches"][name], self.parameters)
        return self._loaded[name]

    def __iter__(self):  # type: ignore[no-untyped-def]
        return iter(self.names)

    def __len__(self) -> int:
        return len(self.names)

    def __contains__(self, name: object) -> bool:
        return name in self.names

    def values(self) -> list[StoredBranch]:
        """All branches, in the file's order."""
        return [self[name] for name in self.names]

    def items(self) -> list[tuple[str, StoredBranch]]:
        """(name, branch) pairs, in the file's order."""
        return [(name, self[name]) for name in self.names]

    def keys(self) -> list[str]:
        """The branches' names."""
        return list(self.names)

    def close(self) -> None:
        """Close the file."""
        self._file.close()

    def __enter__(self) -> BranchFile:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()


def open_branches(path: str | Path) -> BranchFile:
    """Open a branch file (``derod branch``) for reading.

    ``file["3D"].table`` has the fields of POINT (units: D, K0/D^2, K0/D), ``.positions(i)``
    (2k-1, 3) the centre line, ``.arc_length(i)``, ``.drop_center(i)`` (3,), ``.bifurcations`` the
    special points. Raises RecordError.
    """
    return BranchFile(path)
