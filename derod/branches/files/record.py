"""Branch files for reading."""

from __future__ import annotations

from dataclasses import fields
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, Any

from derod.branches.files import checking
from derod.branches.files.layout import FORMATS, OLD_FORMAT, SINCE
from derod.branches.files.stored import StoredBranch
from derod.branches.half_rod.parameters import Parameters
from derod.files import checks
from derod.files.gate import open_gate

if TYPE_CHECKING:
    from derod.views.plots.picture import Picture


class BranchFile:
    """An open branch file: a mapping from names to ``StoredBranch``. Use it as a context or close
    it."""

    def __init__(self, path: str | Path) -> None:
        self.path = Path(path)
        name = str(path)
        self._gate, self._file = open_gate(name, "a branch file")
        try:
            with checks.judged(name):
                self._read_head(name)
        except BaseException:
            self._gate.shut()
            raise

    def _read_head(self, path: str) -> None:
        found = checking.format_of(path, self._file)
        self.checksummed = found != OLD_FORMAT
        attrs = checks.attributes(self._file)
        numbers = {
            f.name: checking.number(attrs, f.name)
            for f in fields(Parameters)
            if FORMATS.index(found) >= FORMATS.index(SINCE.get(f.name, OLD_FORMAT))
        }
        self.parameters = _judged(numbers)
        self.scene_text = str(attrs.get("scene", ""))
        self.names = checking.branch_names(self._file)
        self.complete = bool(attrs.get("complete", True))
        self.settings = str(attrs.get("settings", ""))
        if self.checksummed and checking.head_check(attrs, self.names) != attrs.get("check"):
            raise checks.DamageError("its head does not fit its checksum")
        self._loaded: dict[str, StoredBranch] = {}

    def __getitem__(self, name: str) -> StoredBranch:
        if name not in self.names:
            raise KeyError(f"{self.path}: no branch {name!r}; it has {', '.join(self.names)}")
        if name not in self._loaded:
            with checks.judged(str(self.path)):
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
        """Draw the branches, with ``others`` (runs) beside them; see ``derod.views.plots.plot``."""
        from derod.views.plots import plot

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


def _judged(numbers: dict[str, float]) -> Parameters:
    try:
        return Parameters(**numbers)
    except ValueError as error:
        raise checks.DamageError(f"the parameter {error}") from error


def open_branches(path: str | Path) -> BranchFile:
    """Open a branch file (``derod branch``) for reading.

    ``file["3D"].table`` has the fields of POINT (units: D, K0/D^2, K0/D), ``.positions(i)``
    (2k-1, 3) the centre line, ``.arc_length(i)``, ``.drop_center(i)`` (3,), ``.bifurcations`` the
    special points. Raises RecordError.
    """
    return BranchFile(path)
