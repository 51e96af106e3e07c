"""Finished points on the disk, one small file each, so that a killed sweep loses only what was running.

The folder ``SWEEP.h5.points`` beside the sweep's file holds ``sweep.json``, what is swept, which is locked
while somebody sweeps, and ``POINT-CHECK.h5`` for every finished point: HDF5 made in memory, written under a
passing name and moved into place in one step. CHECK is the checksum of all its bytes; a file that does not
fit its name counts as not there. What is no result (``points.AGAIN``) is not kept here.
"""

from __future__ import annotations

import contextlib
import hashlib
import os
import re
import shutil
from collections.abc import Iterator
from io import BytesIO
from pathlib import Path
from typing import Self

import h5py
import numpy as np

from derod.errors import RecordError, SceneError
from derod.files import outputs
from derod.files.lock import Lock
from derod.files.texts import fixed
from derod.sweeps.plan import MOST_BYTES, Plan, plan_of_text
from derod.sweeps.points import AGAIN, Result
from derod.sweeps.table import PUSHED

HEAD = "sweep.json"
NAME = re.compile(r"([0-9]{6,})-([0-9a-f]{16})\.h5")
FORMAT = 1
COLUMNS = hashlib.blake2b(repr(PUSHED.descr).encode(), digest_size=16).hexdigest()
"""Tells the columns of a row from those of another version."""
LEFT = re.compile(r"\..*\.part")


class Journal:
    """The finished points of one sweep; a context that holds its lock."""

    def __init__(self, target: Path, plan: Plan, lock: Lock) -> None:
        self.folder = folder_of(target)
        self.plan = plan
        self._lock = lock
        self.damaged = 0
        self._files: dict[int, Path] = {}
        for entry in os.scandir(self.folder):
            found = NAME.fullmatch(entry.name)
            if found and int(found[1]) < plan.count:
                self._files[int(found[1])] = Path(entry.path)
            elif LEFT.fullmatch(entry.name):  # of a writer that was killed: the lock is ours now
                with contextlib.suppress(OSError):
                    Path(entry.path).unlink()

    @classmethod
    def begin(cls, target: Path, plan: Plan) -> Self:
        """Make the journal of a sweep that begins; one that is there is replaced. Raises RecordError."""
        folder, head = folder_of(target), folder_of(target) / HEAD
        try:
            if head.exists():
                with Lock.take(str(head)):  # nobody's sweep any more
                    shutil.rmtree(folder)
            folder.mkdir(parents=True, exist_ok=True)
            passing = head.with_name(f".{HEAD}.{os.getpid()}.part")
            passing.write_text(plan.text, encoding="utf-8")
            passing.replace(head)
            return cls(target, plan, Lock.take(str(head)))
        except OSError as error:
            raise RecordError(f"{folder}: cannot be written: {outputs.words(error)}") from error

    @classmethod
    def resume(cls, target: Path) -> Self:
        """Go on with a sweep; every file is held against its checksum. Raises RecordError."""
        head = folder_of(target) / HEAD
        if not head.is_file():
            raise RecordError(f"{target}: no sweep was begun there ({head} is missing)")
        try:
            lock = Lock.take(str(head))
            if head.stat().st_size > MOST_BYTES:
                raise RecordError(f"{head}: is too long to be a sweep of derod")
            journal = cls(target, plan_of_text(head.read_text("utf-8"), str(head)), lock)
        except (OSError, ValueError, SceneError) as error:
            raise RecordError(f"{head}: cannot be read: {error}") from error
        for point in list(journal._files):
            try:
                journal.read(point)
            except RecordError:
                journal._files.pop(point).unlink(missing_ok=True)
                journal.damaged += 1
        return journal

    def __len__(self) -> int:
        return len(self._files)

    def __contains__(self, point: int) -> bool:
        return point in self._files

    def __iter__(self) -> Iterator[int]:
        return iter(sorted(self._files))

    def put(self, result: Result) -> None:
        """Keep a result, unless it is to be tried again. Raises RecordError where it cannot be written."""
        if result.outcome in AGAIN:
            return
        data = encoded(result)
        path = self.folder / f"{result.point:06}-{checksum(data)}.h5"
        passing = path.with_name(f".{path.name}.part")
        try:
            passing.write_bytes(data)
            passing.replace(path)
        except OSError as error:
            with contextlib.suppress(OSError):
                passing.unlink()
            raise RecordError(
                f"{self.folder}: cannot be written: {outputs.words(error)}; "
                f"{len(self)} of {self.plan.count} points are kept"
            ) from error
        self._files[result.point] = path

    def read(self, point: int) -> Result:
        """A result that was kept. Raises RecordError where it does not fit its checksum."""
        path = self._files[point]
        try:
            data = path.read_bytes()
        except OSError as error:
            raise RecordError(f"{path}: cannot be read: {outputs.words(error)}") from error
        if not path.name.endswith(f"-{checksum(data)}.h5"):
            raise RecordError(f"{path}: is damaged: it does not fit its checksum")
        return decoded(data, str(path))

    def remove(self) -> None:
        """Take the journal off the disk: all of it is in the sweep's file."""
        self.close()
        shutil.rmtree(self.folder, ignore_errors=True)

    def close(self) -> None:
        """Let others go on with it."""
        self._lock.release()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


def folder_of(target: Path) -> Path:
    """The folder of the finished points of the sweep file ``target``."""
    return target.with_name(f"{target.name}.points")


def checksum(data: bytes) -> str:
    """64 bits of BLAKE2b, in hexadecimal."""
    return hashlib.blake2b(data, digest_size=8, person=b"point").hexdigest()


def encoded(result: Result) -> bytes:
    """A result as the bytes of an HDF5 file."""
    with h5py.File(
        "point", "w", driver="core", backing_store=False, libver=("v110", "v110")
    ) as file:
        file.attrs["derod_point"] = FORMAT
        file.attrs["point"] = result.point
        file.attrs["outcome"] = fixed(result.outcome)
        file.attrs["message"] = fixed(result.message)
        file.attrs["seconds"] = result.seconds
        file.attrs["columns"] = fixed(COLUMNS)
        # as bytes: HDF5 takes 2 ms to write a record of so many fields, and 5 ms to read it
        file.create_dataset("rows", data=np.frombuffer(result.rows.tobytes(), "u1"))
        file.flush()
        return bytes(file.id.get_file_image())


def decoded(data: bytes, path: str) -> Result:
    """The result that ``encoded`` wrote, of bytes whose checksum was right. Raises RecordError."""
    with h5py.File(BytesIO(data), "r") as file:
        if int(file.attrs.get("derod_point", -1)) != FORMAT:
            raise RecordError(f"{path}: was written by another version of derod")
        if _text(file.attrs["columns"]) != COLUMNS:
            raise RecordError(f"{path}: has other columns: another version of derod wrote it")
        stored = np.frombuffer(file["rows"][:].tobytes(), PUSHED)
        attrs = file.attrs
        return Result(
            int(attrs["point"]), _text(attrs["outcome"]), _text(attrs["message"]),
            stored, float(attrs["seconds"]),
        )  # fmt: skip


def _text(value: bytes | str) -> str:
    return value.decode("utf-8", "replace") if isinstance(value, bytes) else str(value)
