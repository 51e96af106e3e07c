"""What tells how far a run file goes, read and judged when the file is opened."""

from __future__ import annotations

import os

import h5py
import numpy as np

from derod.errors import RecordError
from derod.files import checks
from derod.files.digest import committed_digest, record_digest
from derod.files.gate import Gate
from derod.pushing.frames import Ending, Outcome
from derod.pushing.rows import ROW
from derod.record import layout


class WrongKindError(RecordError):
    """A file that is whole, but no run file this derod can read."""


class Head:
    """Format, counters and ending of a run file, and the datasets that were looked at.

    Raises RecordError where one is missing, of another kind, or says what cannot be.
    """

    def __init__(self, path: str, gate: Gate, file: h5py.File) -> None:
        self.path, self.gate, self.file = path, gate, file
        self.found: dict[str, h5py.Dataset] = {}
        self.pulse_seen: dict[str, bytes] = {}
        with checks.judged(path):
            gate.allow(0)
            self.format = format_of(path, file)
            self._read_committed()
            self._look_at_frames()
            self._look_at_events()
            self.ending = self._read_ending()
            parameters = checks.part(file, "parameters")
            self.created = str(checks.attribute(parameters, "created"))
            scene = self._dataset(layout.SCENE)
            if scene.shape != () or scene.dtype.kind != "S":
                raise checks.DamageError(f"{layout.SCENE} is no text")
            if scene.dtype.itemsize > checks.MOST_TEXT:
                raise checks.DamageError(f"{layout.SCENE} is too long")

    @property
    def checksummed(self) -> bool:
        """Whether the file carries checksums."""
        return self.format > layout.UNCHECKED

    def is_current(self) -> bool:
        """Whether nothing was committed since this was read."""
        return all(self._raw(name) == seen for name, seen in self.pulse_seen.items())

    def _dataset(self, name: str) -> h5py.Dataset:
        found = self.found[name] = checks.dataset(self.file, self.gate, name)
        return found

    def _raw(self, name: str) -> bytes:
        """The bytes of a contiguous dataset as the file has them now."""
        found = self.found[name]
        size = found.dtype.itemsize * found.size
        return os.pread(self.gate.descriptor, size, found.id.get_offset())

    def _now(self, name: str) -> np.ndarray:
        """The values of a small dataset as the file has them now; they are kept as the pulse."""
        raw = self._raw(name)
        self.pulse_seen[name] = raw
        return np.frombuffer(raw, self.found[name].dtype)

    def _read_committed(self) -> None:
        counter = self._dataset(layout.COMMITTED)
        if counter.dtype != "i8" or counter.shape != (2,):
            raise checks.DamageError("the commit counter is of another kind")
        frames, events = (int(value) for value in self._now(layout.COMMITTED))
        if frames < 0 or events < 0:
            raise checks.DamageError(f"it says that {frames} frames and {events} events are whole")
        self.frames, self.events = frames, events
        if self.checksummed:
            slots = self._dataset(layout.COMMITTED_CHECK)
            if slots.dtype != "u8" or slots.shape != (2,):
                raise checks.DamageError("the commit counter's checksum is of another kind")
            seen = {int(slot) for slot in self._now(layout.COMMITTED_CHECK)}
            self.frames, self.events = confirmed(frames, events, seen)

    def _look_at_frames(self) -> None:
        table = self._dataset(f"{layout.TABLE}/value")
        checks.same_types(table.dtype, layout.OLDEST_COLUMNS, layout.TABLE)
        known = {name: ROW[name] for name in table.dtype.names if name in (ROW.names or ())}
        checks.same_types(table.dtype, known, layout.TABLE)
        if self.checksummed and table.dtype.names[-1] != layout.CHECK:
            raise checks.DamageError(f"{layout.TABLE} lacks its checksums")
        position = self._dataset(f"{layout.POSITION}/value")
        if position.ndim != 3:
            raise checks.DamageError(f"{layout.POSITION} is of another shape")
        nodes = position.shape[1]
        shapes = {
            layout.POSITION: (nodes, 3),
            layout.ARC_LENGTH: (nodes,),
            layout.EDGE_TENSION: (nodes - 1,),
            layout.DROP: (1, 3),
        }
        if layout.EDGE_FRAME in self.file:
            shapes[layout.EDGE_FRAME] = (nodes - 1, 7)
        for name, shape in shapes.items():
            values = self._dataset(f"{name}/value")
            if values.shape[1:] != shape or values.dtype != "f8":
                raise checks.DamageError(f"{name} is of another shape or type")
        step, time = (self._dataset(f"{layout.POSITION}/{name}") for name in ("step", "time"))
        if (step.dtype, time.dtype) != ("i8", "f8") or (step.ndim, time.ndim) != (1, 1):
            raise checks.DamageError("steps and times are of another kind")
        if table.ndim != 1:
            raise checks.DamageError(f"{layout.TABLE} is of another shape")
        for name, values in self.found.items():
            if name not in (layout.COMMITTED, layout.COMMITTED_CHECK):
                checks.rows(values, self.gate, self.frames)

    def _look_at_events(self) -> None:
        events = self._dataset(layout.EVENTS)
        if events.ndim != 1 or events.dtype not in layout.EVENT_TYPES[self.checksummed]:
            raise checks.DamageError("its events are of another kind")
        checks.rows(events, self.gate, self.events)

    def _read_ending(self) -> Ending | None:
        ending = self._dataset(layout.ENDING)
        allowed = layout.ENDING_TYPES[self.checksummed]
        if ending.shape != (1,) or ending.dtype not in allowed:
            raise checks.DamageError("its ending is of another kind")
        stored = self._now(layout.ENDING)[0]
        if self.checksummed and int(stored[layout.CHECK]) != record_digest(b"ending", 0, stored):
            raise checks.DamageError("its ending does not fit its checksum")
        outcome = layout.decoded(bytes(stored["outcome"]))
        if not outcome:
            return None
        if outcome not in set(Outcome):
            raise checks.DamageError(f"it ended in an unknown way, {outcome!r}")
        message = layout.decoded(bytes(stored["message"]))
        known = "compiling" in (stored.dtype.names or ())
        compiling = float(stored["compiling"]) if known else 0.0
        return Ending(Outcome(outcome), message, float(stored["end_shortening"]), compiling)


def confirmed(frames: int, events: int, slots: set[int]) -> tuple[int, int]:
    """The counter that its checksums confirm: this one, or the one that was about to be written.

    What a counter counts is whole before its checksum is written, and that before the counter itself.
    """
    for counter in ((frames + 1, events), (frames, events + 1), (frames, events)):
        if committed_digest(*counter) in slots:
            return counter
    raise checks.DamageError("the commit counter does not fit its checksum")


def format_of(path: str, file: h5py.File) -> int:
    """The version of the layout; raises WrongKindError, DamageError."""
    if "derod_format" not in file.attrs:
        if "format" in file.attrs and str(checks.attribute(file, "format")).startswith(
            "derod-branches"
        ):
            raise WrongKindError(f"{path}: is a branch file, not a run file: try derod view {path}")
        raise WrongKindError(f"{path}: is not a run file of derod")
    version = checks.attribute(file, "derod_format")
    if not np.issubdtype(np.asarray(version).dtype, np.integer) or np.ndim(version) or version < 1:
        raise checks.DamageError(f"its format is {version!r}")
    if version > layout.FORMAT:
        raise WrongKindError(f"{path}: was written by a newer derod (format {version})")
    return int(version)
