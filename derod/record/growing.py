"""The HDF5 file under a running push: it grows by whole frames and stays readable at every moment.

Two things make it so. The counter ``committed`` is written after everything it counts, so a killed
process leaves at most an uncounted frame. And room on the disk is taken before HDF5 needs it: a
write that fails inside HDF5 leaves a library that crashes when the file is closed, so none may fail
there.
"""

from __future__ import annotations

import contextlib
import datetime
import functools
import os
import platform
from importlib import metadata

import h5py
import numpy as np

from derod.errors import RecordError
from derod.files.checks import attributes
from derod.files.digest import committed_digest, frame_digest, head_digest, record_digest
from derod.files.lock import Lock
from derod.files.texts import fixed
from derod.pushing.frames import Ending, Event, Frame
from derod.record import layout
from derod.record.column import Cell, Column
from derod.record.reader import Run
from derod.record.verify import HEAD, whole_frames
from derod.scene import Scene
from derod.scene.program import legs

METADATA_BYTES = 128 * 1024
"""Room kept for HDF5's own bookkeeping ahead of a frame; its largest index block is smaller."""
FRAMES_AHEAD = 8


class NoRoomError(OSError):
    """The disk, or a quota, has no room for another frame; the file is in order."""


class GrowingFile:
    """An HDF5 run file open for writing; methods raise OSError or RuntimeError when they fail."""

    def __init__(self, path: str, scene: Scene, created: str | None = None) -> None:
        """Make the file ``path``, which must not exist, and lock it until it is closed."""
        edges = scene.mesh.edges
        self.path = path
        self.nodes = edges + 1
        self.frames = 0
        self.events = 0
        per_edge = 8 if scene.has_frames else 1
        self._frame_bytes = 8 * (4 * self.nodes + per_edge * edges + 5) + layout.STORED_ROW.itemsize
        self._reserved = 0
        self._lock = Lock.make(path)
        try:
            self._file = h5py.File(path, "w", libver=layout.LIBVER, locking=False)
        except BaseException:
            self._lock.release()
            raise
        try:
            self._tail = open(path, "r+b", buffering=0)  # noqa: SIM115, PTH123  closed in close()
            self._reserve()
            self._create(scene, created)
            self._file.flush()
            self._file.swmr_mode = True
        except BaseException:
            self.abandon()
            raise

    def append_frame(self, frame: Frame) -> None:
        """Write one frame and commit it."""
        self._write_frame(frame, self.frames)
        self._commit(self.frames + 1, self.events)

    def append_event(self, event: Event) -> None:
        """Write one event and commit it."""
        self._write_event(event, self.events)
        self._commit(self.frames, self.events + 1)

    def copy(self, run: Run) -> None:
        """Write the frames of ``run``, and the events before them, and commit them as a whole.

        Each frame is held against its checksum on the way. Raises RecordError.
        """
        stored = run.stored_table()
        comparable = run.checksummed and run.has_our_columns
        whole = len(run) if comparable or not run.checksummed else whole_frames(run)
        for i in range(len(run)):
            check = self._write_frame(run.frame_at(i), i)
            if i >= whole or (comparable and check != int(stored[i][layout.CHECK])):
                raise RecordError(
                    f"{run.path}: is damaged: increment {i} of {len(run)} does not fit its checksum"
                )
        events = [event for event in run.events if event.increment < len(run)]
        for i, event in enumerate(events):
            self._write_event(event, i)
        self._commit(len(run), len(events))

    def _write_frame(self, frame: Frame, i: int) -> int:
        """Write a frame; return its checksum."""
        self._reserve()
        given = [frame.positions, frame.arc_length, frame.edge_tension, frame.drop_center]
        if frame.edge_frame is not None:
            given.append(frame.edge_frame)
        arrays = [np.ascontiguousarray(array, dtype="f8") for array in given]
        time = float(frame.row[self._controls[int(frame.row["segment"])]])
        row = frame.row.tobytes()
        check = frame_digest(i, row, arrays, time)
        self._row[:] = np.frombuffer(row + check.to_bytes(8, "little"), "u1")
        for name, array in zip(self._arrays, arrays, strict=True):
            self._values[name].write(i, array)
        self._values[layout.TABLE].write(i, self._row.view(layout.STORED_ROW)[0])
        self._step.write(i, i)
        self._time.write(i, time)
        return check

    def _write_event(self, event: Event, i: int) -> None:
        self._reserve()
        record = layout.record(
            layout.STORED_EVENT,
            (
                event.increment,
                layout.encoded(event.kind, layout.KIND_BYTES),
                event.end_shortening,
                event.energy_before,
                event.energy_after,
                layout.encoded(event.message, layout.MESSAGE_BYTES),
                event.control_value,
                0,
            ),
        )
        record[layout.CHECK] = record_digest(b"event", i, record)
        self._events.write(i, record)

    def _commit(self, frames: int, events: int) -> None:
        """Let the operating system have everything, then the counter."""
        if frames != self.frames:
            for column in (*self._values.values(), self._step, self._time):
                column.flush()
        if events != self.events:
            self._events.flush()
        self._slots.reverse()
        self._slots[0] = committed_digest(frames, events)
        self._committed_check.write(self._slots)
        self._committed.write((frames, events))
        self.frames, self.events = frames, events

    def write_ending(self, ending: Ending) -> None:
        """Write how the push ended; the place for it was taken at the beginning."""
        self._ending[0] = stored_ending(
            layout.encoded(ending.outcome, layout.KIND_BYTES),
            layout.encoded(ending.message, layout.MESSAGE_BYTES),
            ending.end_shortening,
            ending.compiling,
        )
        self._ending.flush()

    def close(self) -> None:
        """Give back the room not used, close the file, let others write it."""
        self._tail.truncate(self._file.id.get_filesize())
        self._tail.close()
        self._file.close()
        self._lock.release()

    def abandon(self) -> None:
        """Close without writing anything more, after a write has failed.

        HDF5 would try the failed write again and crash the process; its writes are sent to nowhere.
        """
        descriptor = self._file.id.get_vfd_handle()
        nowhere = os.open(os.devnull, os.O_RDWR)
        os.dup2(nowhere, descriptor)
        os.close(nowhere)
        with contextlib.suppress(OSError, RuntimeError):  # nowhere has no length to set
            self._file.close()
        if hasattr(self, "_tail"):
            self._tail.close()
        self._lock.release()

    def is_at(self, path: str) -> bool:
        """Whether ``path`` still leads to this file: neither moved, deleted nor replaced."""
        try:
            there = os.stat(path)  # noqa: PTH116  a tenth of the time of Path.stat
        except OSError:
            return False
        here = os.fstat(self._tail.fileno())
        return (there.st_ino, there.st_dev) == (here.st_ino, here.st_dev)

    def _reserve(self) -> None:
        """Take room for the next frame behind the end of what HDF5 has allocated."""
        end = self._file.id.get_filesize()
        need = self._frame_bytes + METADATA_BYTES
        if self._reserved - end >= need:
            return
        ahead = FRAMES_AHEAD * self._frame_bytes + 2 * METADATA_BYTES
        self._tail.seek(end)
        room = memoryview(bytes(ahead))
        try:
            while room:  # a short write comes before the error that tells why
                room = room[self._tail.write(room) :]
        except OSError as error:
            raise NoRoomError(error.errno, error.strerror, self.path) from error
        self._reserved = end + ahead

    def _create(self, scene: Scene, created: str | None) -> None:
        file, edges = self._file, self.nodes - 1
        _write_provenance(file, scene, created)
        box = file.create_group("particles/rod/box")
        box.attrs["dimension"] = 3
        box.attrs["boundary"] = np.array(["none"] * 3, dtype="S4")
        file["particles/drop/box"] = box
        position = layout.POSITION
        self._step = Column(file, f"{position}/step", "i8", per_chunk=1024)
        self._controls = [leg.control for leg in legs(scene)]
        quantities = list(dict.fromkeys(self._controls))
        units = list(dict.fromkeys(layout.ROW_UNITS[name] for name in quantities))
        self._time = Column(file, f"{position}/time", "f8", per_chunk=1024, unit=", ".join(units))
        self._time.dataset.attrs["quantity"] = fixed(", ".join(quantities))
        shapes = {
            layout.POSITION: (self.nodes, 3),
            layout.ARC_LENGTH: (self.nodes,),
            layout.EDGE_TENSION: (edges,),
            layout.DROP: (1, 3),
        }
        if scene.has_frames:
            shapes[layout.EDGE_FRAME] = (edges, 7)
        self._arrays = tuple(shapes)
        self._values = {
            name: Column(file, f"{name}/value", "f8", shape, per_chunk=1, unit=layout.UNITS[name])
            for name, shape in shapes.items()
        }
        table = Column(
            file, f"{layout.TABLE}/value", layout.STORED_ROW, per_chunk=layout.ROWS_PER_CHUNK
        )
        for name, unit in layout.ROW_UNITS.items():
            table.dataset.attrs[f"unit {name}"] = fixed(unit)
        self._values[layout.TABLE] = table
        for name in (*self._arrays[1:], layout.TABLE):
            file[f"{name}/step"] = self._step.dataset
            file[f"{name}/time"] = self._time.dataset
        self._events = Column(file, layout.EVENTS, layout.STORED_EVENT, per_chunk=16)
        self._ending = file.create_dataset(
            layout.ENDING, data=np.array([stored_ending(b"", b"", 0.0, 0.0)])
        )
        self._slots = [committed_digest(0, 0)] * 2
        self._committed_check = Cell(file, layout.COMMITTED_CHECK, "u8", self._slots)
        self._committed = Cell(file, layout.COMMITTED, "i8", (0, 0))
        self._row = np.zeros(layout.STORED_ROW.itemsize, "u1")
        text = scene.text.encode("utf-8")
        head = (*HEAD, f"{layout.EDGE_FRAME}/value") if scene.has_frames else HEAD
        heads = {name: attributes(file[name]) for name in head}
        file.attrs[layout.CHECK] = np.uint64(head_digest(text, heads))


def stored_ending(
    outcome: bytes, message: bytes, end_shortening: float, compiling: float
) -> np.void:
    """The record of an ending, with its check."""
    record = layout.record(layout.STORED_ENDING, (outcome, message, end_shortening, compiling, 0))
    record[layout.CHECK] = record_digest(b"ending", 0, record)
    return record


def _write_provenance(file: h5py.File, scene: Scene, created: str | None) -> None:
    file.attrs["derod_format"] = layout.FORMAT
    now = datetime.datetime.now(datetime.UTC).isoformat(timespec="seconds")
    h5md = file.create_group("h5md")
    h5md.attrs["version"] = np.array(layout.H5MD_VERSION, dtype="i4")
    h5md.create_group("author").attrs["name"] = fixed("unknown")
    creator = h5md.create_group("creator")
    creator.attrs["name"] = fixed("derod")
    creator.attrs["version"] = fixed(_version("derod"))
    parameters = file.create_group("parameters")
    parameters.attrs["created"] = fixed(created or now)
    parameters.attrs["opened"] = fixed(now)
    parameters.attrs["seed"] = scene.noise.seed
    parameters.attrs["platform"] = fixed(platform.platform())
    parameters.attrs["python"] = fixed(platform.python_version())
    for package in ("derod", "numpy", "numba", "h5py"):
        parameters.attrs[package] = fixed(_version(package))
    parameters.attrs["hdf5"] = fixed(h5py.version.hdf5_version)
    text = scene.text.encode("utf-8")
    file.create_dataset(
        layout.SCENE, data=text, dtype=h5py.string_dtype("utf-8", max(len(text), 1))
    )


@functools.cache
def _version(package: str) -> str:
    if package == "derod":
        import derod

        return derod.__version__
    try:
        return metadata.version(package)
    except metadata.PackageNotFoundError:
        return "unknown"
