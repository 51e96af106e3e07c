"""The file of a sweep: one HDF5 file with all outcomes and all rows, in the order of the points.

::

    /sweep       what was swept: the text of the plan
    /outcomes    (P) of ``table.outcome_type``: one a point
    /rows        (R) of ``table.row_type``

The root's attributes are ``derod_sweep``, the format, ``complete``, and a checksum of each dataset. There
is no time, machine or number of workers in it: the same sweep gives the same bytes.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any, Self

import h5py
import numpy as np

from derod.files import checks, outputs
from derod.files.digest import digest
from derod.files.gate import open_gate
from derod.files.texts import fixed
from derod.needs import need
from derod.record.layout import encoded
from derod.sweeps.plan import Plan, plan_of_text
from derod.sweeps.points import Result
from derod.sweeps.sampling import Point
from derod.sweeps.table import (
    MESSAGE_BYTES,
    PUSHED,
    UNITS,
    fill_keys,
    key_columns,
    outcome_type,
    row_type,
)

FORMAT = 1
MARK = "derod_sweep"
PLAN, OUTCOMES, ROWS = "sweep", "outcomes", "rows"
ROOM = 2**16
"""Bytes kept free for HDF5's own blocks when the file is closed."""
BLOCK = 4096
"""Rows that are written, or read, at once."""
SET_ASIDE = "not_reached"
"""The outcome of points that were not pushed when the file was written."""


def write_sweep(
    path: Path, plan: Plan, read: Callable[[int], Result | None], counts: Mapping[int, int]
) -> None:
    """Write the file of a sweep, one point after another, and put it in the place of ``path``.

    ``read(point)`` gives a result, or None where there is none yet; ``counts`` are the rows of those that
    have any. Raises RecordError; a file that was there then stays.
    """
    points: list[Point] = list(plan.points())
    columns = key_columns(plan.keys, points)
    total = sum(counts.values())
    with outputs.replacing(path, force=True) as passing:
        file = h5py.File(passing, "w", libver=("v110", "v110"), locking=False)
        try:
            text = plan.text.encode()
            file.create_dataset(PLAN, data=np.frombuffer(text, f"S{len(text)}")[0])
            rows = _contiguous(file, ROWS, total, row_type(columns))
            outcomes = _contiguous(file, OUTCOMES, plan.count, outcome_type(columns))
            for name, unit in UNITS.items():
                rows.attrs[f"unit {name}"] = fixed(unit)
            _take_room(file, passing)
        except BaseException:
            _abandon(file)
            raise
        with file:
            whole = _fill(plan, points, read, outcomes, rows)
            file.attrs["complete"] = np.int8(whole)
            for dataset in (outcomes, rows):
                file.attrs[f"check {dataset.name[1:]}"] = np.uint64(check_of(dataset))
            file.attrs["check sweep"] = np.uint64(digest(b"sweep", 0, (text,)))
            file.attrs[MARK] = np.int64(FORMAT)


def _fill(
    plan: Plan,
    points: list[Point],
    read: Callable[[int], Result | None],
    outcomes: h5py.Dataset,
    rows: h5py.Dataset,
) -> bool:
    """Write every point in turn; return whether all were pushed."""
    first, whole = 0, True
    lines, kept = _Blocks(outcomes), _Blocks(rows)
    for point, values in enumerate(points):
        result = read(point)
        whole = whole and result is not None
        if result is None:
            result = Result(point, SET_ASIDE, "", np.zeros(0, PUSHED))
        line = np.zeros(1, lines.dtype)
        fill_keys(line, plan.keys, values)
        line["point"], line["first_row"], line["rows"] = point, first, len(result.rows)
        line["outcome"] = result.outcome.encode()
        line["message"] = encoded(result.message, MESSAGE_BYTES)
        lines.add(line)
        own = np.zeros(len(result.rows), kept.dtype)
        own["point"] = point
        fill_keys(own, plan.keys, values)
        for name in PUSHED.names or ():
            own[name] = result.rows[name]
        kept.add(own)
        first += len(own)
    lines.write()
    kept.write()
    return whole


class _Blocks:
    """Writes a table some thousand rows at a time: a call costs h5py more than many rows do."""

    def __init__(self, dataset: h5py.Dataset) -> None:
        self.dataset, self.dtype = dataset, dataset.dtype
        self._waiting: list[np.ndarray] = []
        self._count = self._done = 0

    def add(self, rows: np.ndarray) -> None:
        """Take in rows (k,)."""
        self._waiting.append(rows)
        self._count += len(rows)
        if self._count >= BLOCK:
            self.write()

    def write(self) -> None:
        """Write what is waiting."""
        if self._count:
            end = self._done + self._count
            self.dataset[self._done : end] = np.concatenate(self._waiting)
            self._done, self._count, self._waiting = end, 0, []


def _contiguous(file: h5py.File, name: str, count: int, dtype: np.dtype) -> h5py.Dataset:
    """A dataset of fixed length whose room in the file is taken now."""
    properties = h5py.h5p.create(h5py.h5p.DATASET_CREATE)
    properties.set_layout(h5py.h5d.CONTIGUOUS)
    properties.set_alloc_time(h5py.h5d.ALLOC_TIME_EARLY)
    properties.set_fill_time(h5py.h5d.FILL_TIME_NEVER)
    properties.set_obj_track_times(False)
    space = h5py.h5s.create_simple((count,))
    kind = h5py.h5t.py_create(dtype, logical=True)
    return h5py.Dataset(h5py.h5d.create(file.id, name.encode(), kind, space, properties))


def _take_room(file: h5py.File, path: Path) -> None:
    """Take all room on the disk before HDF5 writes: a write that fails inside HDF5 cannot be mended."""
    file.flush()
    descriptor = os.open(path, os.O_RDWR)
    try:
        os.posix_fallocate(descriptor, 0, file.id.get_filesize() + ROOM)
    finally:
        os.close(descriptor)


def _abandon(file: h5py.File) -> None:
    """Close a file without writing anything more."""
    nowhere = os.open(os.devnull, os.O_RDWR)
    os.dup2(nowhere, file.id.get_vfd_handle())
    os.close(nowhere)
    try:
        file.close()
    except (OSError, RuntimeError):  # nowhere has no length to set
        return


def check_of(dataset: Any, step: int = BLOCK) -> int:
    """The checksum of a table, read in parts."""

    def parts() -> Iterator[bytes]:
        yield f"{dataset.dtype.descr} {dataset.shape}".encode()
        for i in range(0, len(dataset), step):
            yield dataset[i : i + step].tobytes()

    return digest(b"table", 0, parts())


class Sweep:
    """The file of a sweep, read: ``sweep.outcomes``, ``sweep.rows``, ``sweep["end_tension"]``.

    ``outcomes`` has one row a point, ``rows`` those kept of every push. Lengths are in D, forces in K0/D^2,
    energies in K0/D, angles in rad. Raises RecordError for what is no sweep, or damaged.
    """

    def __init__(self, path: str | os.PathLike[str]) -> None:
        self.path = os.fsdecode(os.fspath(path))
        gate, file = open_gate(self.path, "a sweep file")
        try:
            with checks.judged(self.path):
                if MARK not in file.attrs:
                    raise checks.DamageError("it is no sweep of derod, or was never finished")
                if int(checks.attribute(file, MARK)) > FORMAT:
                    raise checks.DamageError("it was written by a newer derod")
                self.complete = bool(checks.attribute(file, "complete"))
                gate.allow(gate.size)
                self.outcomes = self._read(file, gate, OUTCOMES)
                self.rows = self._read(file, gate, ROWS)
                text = bytes(checks.dataset(file, gate, PLAN)[()])
                if int(checks.attribute(file, "check sweep")) != digest(b"sweep", 0, (text,)):
                    raise checks.DamageError("what was swept does not fit its checksum")
        finally:
            gate.shut()
        self.plan: Plan = plan_of_text(text.decode(), self.path)

    def _read(self, file: h5py.File, gate: Any, name: str) -> np.ndarray:
        found = checks.dataset(file, gate, name)
        if int(checks.attribute(file, f"check {name}")) != check_of(found):
            raise checks.DamageError(f"{name} do not fit their checksum")
        table: np.ndarray = found[:]
        table.flags.writeable = False
        return table

    @property
    def keys(self) -> tuple[str, ...]:
        """The keys that vary."""
        return self.plan.keys

    def __len__(self) -> int:
        """The number of points."""
        return len(self.outcomes)

    def __getitem__(self, column: str) -> np.ndarray:
        """A column of ``rows``; raises KeyError with the names that there are."""
        if column not in (self.rows.dtype.names or ()):
            raise KeyError(
                f"no column {column!r}; allowed: {', '.join(self.rows.dtype.names or ())}"
            )
        found: np.ndarray = self.rows[column]
        return found

    def failures(self) -> np.ndarray:
        """The outcomes that are not "completed"."""
        chosen: np.ndarray = self.outcomes[self.outcomes["outcome"] != b"completed"]
        return chosen

    def to_pandas(self) -> Any:
        """``rows`` as a pandas.DataFrame; units in ``.attrs["units"]``.

        Raises ``derod.needs.MissingError``.
        """
        pandas = need("pandas", "to_pandas")
        table = pandas.DataFrame(
            {name: texts(self.rows[name]) for name in self.rows.dtype.names or ()}
        )
        table.attrs["units"] = {name: UNITS.get(name, "") for name in table.columns}
        return table

    def plot(self, kind: str = "phase", *others: Any, **options: Any) -> Any:
        """Draw the sweep, with branch files on top; see ``derod.views.plots.plot``."""
        from derod.views.plots import plot

        return plot(kind, [self, *others], **options)

    def close(self) -> None:
        """Nothing is open: all of it was read."""

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def __repr__(self) -> str:
        failed = len(self.failures())
        return (
            f"<sweep {self.path}: {len(self)} points over {', '.join(self.keys)}, "
            f"{len(self.rows)} rows, {failed} not completed>"
        )


def open_sweep(path: str | os.PathLike[str]) -> Sweep:
    """Open the file of a sweep (``derod sweep``) for reading. Raises RecordError."""
    return Sweep(path)


def texts(column: np.ndarray) -> np.ndarray:
    """A column whose texts are texts of Python."""
    return np.char.decode(column, "utf-8", "replace") if column.dtype.kind == "S" else column
