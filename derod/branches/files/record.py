"""Branch files (HDF5): one group a branch, everything needed to draw it, compare with it, restart
from it.

Layout: attributes ``format``, ``parameters`` (one dataset of the dimensionless numbers),
``scene`` (its text); ``branches/NAME`` with ``table`` (one row a point), ``nodes`` and ``eta``
(the half rod's node states and element lengths of all points, one after another) and
``bifurcations``. ``check`` is the checksum of a group, and at the root of all but the groups. Every branch
is written as it is done, in one step; the attribute ``complete`` is true when all that were asked for are
there. Files of derod 0.1 (format 1) have neither. Files before format 3 have no ``weight`` among the
parameters: 0.
"""

from __future__ import annotations

from dataclasses import fields
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, Any

import h5py
import numpy as np

from derod import hdf5
from derod.branches.files import checking
from derod.branches.files.stored import StoredBranch
from derod.branches.half_rod.observables import SCALED
from derod.branches.half_rod.parameters import Parameters

if TYPE_CHECKING:
    from derod.branches.paths.branch import Branch
    from derod.plots.picture import Picture

FORMAT = checking.FORMATS[-1]
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


def write_branches(
    path: str | Path,
    parameters: Parameters,
    branches: list[Branch],
    scene_text: str = "",
    *,
    overwrite: bool = True,
) -> None:
    """Write branches to a file, complete or not at all. Raises RecordError, OSError."""
    from derod.branches.files.writing import BranchWriter, Settings

    settings = Settings()
    with BranchWriter(
        path, parameters, scene_text, settings, overwrite=overwrite, reserve=False
    ) as writer:
        writer.put(*branches, complete=True)


def write_branch(group: h5py.Group, branch: Branch) -> None:
    """Write one branch into its group."""
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
        row["scalars"] = point.state.scalars[:6]  # the weight is an attribute of the file
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
    group.attrs["check"] = np.uint64(checking.group_check(branch.name, group))


class BranchFile:
    """An open branch file: a mapping from names to ``StoredBranch``. Use it as a context or close
    it."""

    def __init__(self, path: str | Path) -> None:
        self.path = Path(path)
        name = str(path)
        self._gate, self._file = hdf5.open_gate(name, "a branch file")
        try:
            with hdf5.checks.judged(name):
                self._read_head(name)
        except BaseException:
            self._gate.shut()
            raise

    def _read_head(self, path: str) -> None:
        found = checking.format_of(path, self._file)
        self.checksummed = found != checking.OLD_FORMAT
        attrs = hdf5.checks.attributes(self._file)
        numbers = {
            f.name: checking.number(attrs, f.name)
            for f in fields(Parameters)
            if f.name != "weight" or found == FORMAT
        }
        self.parameters = Parameters(**numbers)
        self.scene_text = str(attrs.get("scene", ""))
        self.names = checking.branch_names(self._file)
        self.complete = bool(attrs.get("complete", True))
        self.settings = str(attrs.get("settings", ""))
        if self.checksummed and checking.head_check(attrs, self.names) != attrs.get("check"):
            raise hdf5.checks.DamageError("its head does not fit its checksum")
        self._loaded: dict[str, StoredBranch] = {}

    def __getitem__(self, name: str) -> StoredBranch:
        if name not in self.names:
            raise KeyError(f"{self.path}: no branch {name!r}; it has {', '.join(self.names)}")
        if name not in self._loaded:
            with hdf5.checks.judged(str(self.path)):
                group = checking.checked_group(self._file, self._gate, name, self.checksummed)
                self._loaded[name] = StoredBranch(name, group, self.parameters)
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

    def plot(self, kind: str = "path", *others: Any, **options: Any) -> Picture:
        """Draw the branches, with ``others`` (runs) beside them; see ``derod.plots.plot``."""
        from derod.plots import plot

        return plot(kind, [self, *others], **options)

    def close(self) -> None:
        """Close the file."""
        self._gate.shut()

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
