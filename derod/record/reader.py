"""Run files as they are read, also while they are written."""

from __future__ import annotations

import os
import struct
import time
from pathlib import Path
from typing import Any, Self

import h5py
import numpy as np

from derod.errors import RecordError
from derod.frames import Ending, Event, Outcome
from derod.record import layout
from derod.record.run import BaseRun
from derod.scene import Scene, parse_scene

OPEN_TRIES = 5
OPEN_PAUSE = 0.02  # s
SIGNATURE = b"\x89HDF\r\n\x1a\n"
SUPERBLOCK = struct.Struct("<8sB19xQ")  # version 2 and 3: signature, version, end of the file


class Run(BaseRun):
    """A run file; see ``open_run``. The frames stay those of the last ``refresh``."""

    def __init__(self, path: str | os.PathLike[str]) -> None:
        self.path: str = os.fspath(path)
        self._scene: Scene | None = None
        self._table: np.ndarray | None = None
        self._file = _open(self.path)
        try:
            self._read_head()
        except BaseException as error:
            self._file.close()
            if isinstance(error, KeyError | OSError | RuntimeError | ValueError):
                raise RecordError(f"{self.path}: is damaged: {error}") from error
            raise

    @property
    def scene(self) -> Scene:
        """The scene as it was run."""
        if self._scene is None:
            text = self._file[layout.SCENE][()]
            self._scene = parse_scene(text.decode("utf-8"), path=self.path)
        return self._scene

    @property
    def table(self) -> np.ndarray:
        """One row for each settled increment, (T,), read-only."""
        if self._table is None:
            table: np.ndarray = self._read(f"{layout.TABLE}/value", slice(self._frames))
            table.flags.writeable = False
            self._table = table
        return self._table

    @property
    def extrapolated(self) -> np.ndarray | None:
        """The rows of ``derod.extrapolate``, or None where the push was not extrapolated."""
        if layout.EXTRAPOLATED not in self._file:
            return None
        return self._read(layout.EXTRAPOLATED, slice(None))

    @property
    def events(self) -> tuple[Event, ...]:
        """What happened between the frames."""
        stored = self._read(layout.EVENTS, slice(self._events))
        return tuple(
            Event(
                increment=int(event["increment"]),
                kind=layout.decoded(event["kind"]),
                end_shortening=float(event["end_shortening"]),
                energy_before=float(event["energy_before"]),
                energy_after=float(event["energy_after"]),
                message=layout.decoded(event["message"]),
            )
            for event in stored
        )

    @property
    def ending(self) -> Ending | None:
        """How the push ended, or None."""
        return self._ending

    @property
    def versions(self) -> dict[str, Any]:
        """Versions, platform, seed and times of making, as recorded."""
        return dict(self._file["parameters"].attrs)

    def __len__(self) -> int:
        return self._frames

    def refresh(self) -> Self:
        """Take in what was recorded since, also into a file that took the place of this one."""
        try:
            replaced = not os.path.samestat(os.stat(self.path), self._stat)  # noqa: PTH116
        except OSError:
            replaced = False  # moved or deleted: what is open stays readable
        if replaced:
            fresh = _open(self.path)
            self._file.close()
            self._file = fresh
        self._read_head()
        return self

    def close(self) -> None:
        """Let go of the file; the table, once read, stays."""
        self._file.close()

    def field(self, name: str, i: int) -> np.ndarray:
        """The array of increment ``i`` that the layout calls ``name``."""
        return self._read(f"{name}/value", i)

    def _read(self, name: str, what: Any) -> np.ndarray:
        """Part of a dataset as it is now.

        HDF5 keeps what it once read of a file, for all who open it in a process, and forgets it on
        demand only while nobody holds the dataset open: so it is opened for each reading.
        """
        dataset = self._file[name]
        if self._file.swmr_mode and name not in self._fresh:
            dataset.refresh()
            self._fresh.add(name)
        return dataset[what]

    def _read_head(self) -> None:
        """Read what tells how far the file goes."""
        self._scene = self._table = None
        self._fresh: set[str] = set()
        self._stat = os.fstat(self._file.id.get_vfd_handle())
        version = self._file.attrs.get("derod_format")
        if version is None:
            raise RecordError(f"{self.path}: is not a run file of derod")
        if version > layout.FORMAT:
            raise RecordError(f"{self.path}: was written by a newer derod (format {version})")
        frames, events = self._read(layout.COMMITTED, slice(None))
        self._frames, self._events = int(frames), int(events)
        self.created = str(self._file["parameters"].attrs["created"])
        stored = self._read(layout.ENDING, 0)
        outcome = layout.decoded(bytes(stored["outcome"]))
        self._ending = (
            Ending(
                outcome=Outcome(outcome),
                message=layout.decoded(bytes(stored["message"])),
                end_shortening=float(stored["end_shortening"]),
            )
            if outcome
            else None
        )


def open_run(path: str | os.PathLike[str]) -> Run:
    """Open the run file ``path`` for reading, finished, killed or being written by another process.

    Raises RecordError if there is none or it is not one.
    """
    return Run(path)


def is_cut(path: str) -> bool:
    """Whether an HDF5 file is shorter than its superblock says.

    HDF5 does not check this in a file opened as a live one, and then hangs.
    """
    try:
        with Path(path).open("rb") as file:
            head = file.read(SUPERBLOCK.size)
            size = file.seek(0, os.SEEK_END)
    except OSError:  # opening it says why
        return False
    if len(head) < SUPERBLOCK.size:
        return False
    signature, version, end = SUPERBLOCK.unpack(head)
    return signature == SIGNATURE and version in (2, 3) and size < end


def _open(path: str) -> h5py.File:
    """Open for reading; a live or killed file only opens as one that may be written meanwhile."""
    if not Path(path).is_file():
        raise RecordError(f"{path}: there is no such file")
    if is_cut(path):
        raise RecordError(f"{path}: cannot be read as a run file: its end is missing")
    reasons = []
    for attempt in range(OPEN_TRIES):
        if attempt:
            time.sleep(OPEN_PAUSE)  # its header may have been in the middle of a change
        for live in (False, True):
            try:
                return h5py.File(path, "r", swmr=live, locking=False, rdcc_nbytes=0)
            except OSError as error:
                reasons.append(str(error).splitlines()[0])
        if not h5py.is_hdf5(path):
            break
    raise RecordError(f"{path}: cannot be read as a run file: {reasons[-1]}")
