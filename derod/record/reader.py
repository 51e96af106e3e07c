"""Run files as they are read, also while they are written."""

from __future__ import annotations

import os
import time
from typing import Any, Self

import numpy as np

from derod.errors import RecordError, SceneError
from derod.files import checks
from derod.files.digest import record_digest, table_digest
from derod.files.gate import Gate, open_gate
from derod.pushing.frames import Ending, Event
from derod.record import layout
from derod.record.head import Head, WrongKindError
from derod.record.run import BaseRun
from derod.record.verify import verify_run
from derod.scene import Scene, parse_scene

OPEN_TRIES = 5
OPEN_PAUSE = 0.02  # s
OPEN_PATIENCE = 0.5  # s, after which a file that cannot be opened is not tried again


class Run(BaseRun):
    """A run file; see ``open_run``. The frames stay those of the last ``refresh``."""

    path: str
    _head: Head
    _gate: Gate
    _scene: Scene | None
    _table: np.ndarray | None

    def __init__(self, path: str | os.PathLike[str], *, verify: bool = False) -> None:
        self.path = os.fsdecode(os.fspath(path))
        self._open(None)
        if verify:
            try:
                self.verify()
            except BaseException:
                self.close()
                raise

    @property
    def scene(self) -> Scene:
        """The scene as it was run."""
        if self._scene is None:
            try:
                text = self.scene_text.decode("utf-8")
                self._scene = parse_scene(text, path=self.path)
            except (SceneError, UnicodeDecodeError) as error:
                raise RecordError(f"{self.path}: is damaged: its scene: {error}") from error
        return self._scene

    @property
    def table(self) -> np.ndarray:
        """One row for each settled increment, (T,), read-only."""
        if self._table is None:
            table = layout.as_rows(self.stored_table())
            table.flags.writeable = False
            self._table = table
        return self._table

    @property
    def extrapolated(self) -> np.ndarray | None:
        """The rows of ``derod.record.extrapolate``, or None where the push was not extrapolated."""
        with checks.judged(self.path):
            if layout.EXTRAPOLATED not in self._file:
                return None
            found = checks.dataset(self._file, self._gate, layout.EXTRAPOLATED)
            checks.rows(found, self._gate, self._frames)
            if len(found) != self._frames:
                raise checks.DamageError("rows were extrapolated that are not there")
            table: np.ndarray = self._read(layout.EXTRAPOLATED, slice(None))
            if layout.CHECK in found.attrs and int(
                checks.attribute(found, layout.CHECK)
            ) != table_digest(b"extrapolated", table):
                raise checks.DamageError("the extrapolated rows do not fit their checksum")
        return table

    @property
    def events(self) -> tuple[Event, ...]:
        """What happened between the frames."""
        stored = self._read(layout.EVENTS, slice(self._events))
        if self.checksummed:
            for i, event in enumerate(stored):
                if int(event[layout.CHECK]) != record_digest(b"event", i, event):
                    raise RecordError(
                        f"{self.path}: is damaged: event {i} does not fit its checksum"
                    )
        newer = "control_value" in (stored.dtype.names or ())
        place = "control_value" if newer else "end_shortening"
        return tuple(
            Event(
                increment=int(event["increment"]),
                kind=layout.decoded(event["kind"]),
                end_shortening=float(event["end_shortening"]),
                energy_before=float(event["energy_before"]),
                energy_after=float(event["energy_after"]),
                message=layout.decoded(event["message"]),
                control_value=float(event[place]),
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
        with checks.judged(self.path):
            self._gate.allow(0)
            return checks.attributes(checks.part(self._file, "parameters"))

    @property
    def checksummed(self) -> bool:
        """Whether the file carries checksums: not so those of derod 0.1."""
        return self.format > layout.UNCHECKED

    @property
    def scene_text(self) -> bytes:
        """The scene's text as it is stored."""
        value = self._read(layout.SCENE, ())
        return bytes(value)

    def __len__(self) -> int:
        return self._frames

    def verify(self) -> int:
        """Read everything back and hold it against its checksum; return the number of frames.

        Raises RecordError, which names the first frame that does not fit, or says that the file has no
        checksums.
        """
        return verify_run(self)

    def refresh(self) -> Self:
        """Take in what was recorded since, also into a file that took the place of this one."""
        try:
            there = os.stat(self.path)  # noqa: PTH116
        except OSError:
            there = self._gate.stat  # moved or deleted: what is open stays readable
        if not os.path.samestat(there, self._gate.stat):
            self._open(None)
        elif not self._head.is_current():
            self._open(self._gate.descriptor)
        return self

    def close(self) -> None:
        """Let go of the file; the table, once read, stays."""
        self._gate.shut()

    @property
    def has_our_columns(self) -> bool:
        """Whether its rows have the columns of today, so that copied rows keep their checks."""
        return layout.has_our_columns(self._found[f"{layout.TABLE}/value"].dtype)

    @property
    def has_edge_frames(self) -> bool:
        """Whether it records the frames of a section with directions."""
        return f"{layout.EDGE_FRAME}/value" in self._head.found

    def field(self, name: str, i: int) -> np.ndarray:
        """The array of increment ``i`` that the layout calls ``name``."""
        return self._read(f"{name}/value", i)

    def stored_table(self) -> np.ndarray:
        """The committed rows as they are stored, with their checks."""
        return self._read(f"{layout.TABLE}/value", slice(self._frames))

    def read_back(self, i: int | slice, names: tuple[str, ...]) -> list[np.ndarray]:
        """What the layout calls by ``names`` (``.../value`` and so on) of increment ``i``."""
        return [self._read(name, i) for name in names]

    def attributes_of(self, places: tuple[str, ...]) -> dict[str, dict[str, Any]]:
        """The attributes of the objects at ``places``; "" is the root."""
        with checks.judged(self.path):
            self._gate.allow(0)
            return {
                place: checks.attributes(checks.part(self._file, place) if place else self._file)
                for place in places
            }

    def _read(self, name: str, what: Any) -> Any:
        """Part of a dataset, looked at before it is read."""
        with checks.judged(self.path):
            self._gate.allow(0)
            found = self._found.get(name)
            if found is None:
                found = self._found[name] = checks.dataset(self._file, self._gate, name)
            if isinstance(what, int):
                checks.stored(found, self._gate, what)
                self._gate.allow(found.dtype.itemsize * found.size // max(len(found), 1))
            elif what != ():
                self._gate.allow(found.dtype.itemsize * found.size)
            return found[what]

    def _open(self, descriptor: int | None) -> None:
        """Open the file, by its name or the descriptor of the one that is open, and read its head."""
        began = time.monotonic()
        for attempt in range(OPEN_TRIES):
            gate: Gate | None = None
            try:
                gate, file = open_gate(self.path, descriptor=descriptor)
                head = Head(self.path, gate, file)
                break
            except RecordError as error:
                if gate is not None:
                    gate.shut()
                late = time.monotonic() - began > OPEN_PATIENCE
                if late or attempt == OPEN_TRIES - 1 or isinstance(error, WrongKindError):
                    raise
                time.sleep(OPEN_PAUSE)  # it may have been in the middle of a change
        if hasattr(self, "_head"):
            self.close()
        self._head = head
        self._gate, self._file, self._found = head.gate, file, head.found
        self.format, self.created = head.format, head.created
        self._frames, self._events, self._ending = head.frames, head.events, head.ending
        self._scene = None
        self._table = None


def open_run(path: str | os.PathLike[str], *, verify: bool = False) -> Run:
    """Open the run file ``path`` for reading, finished, killed or being written by another process.

    With ``verify`` all of it is read back and held against its checksums first (``Run.verify``).
    Raises RecordError if there is none, it is not one, or it is damaged.
    """
    return Run(path, verify=verify)
