"""The observer that keeps a push in a run file, and the way back into a file to go on."""

from __future__ import annotations

import contextlib
import os
import re
from collections.abc import Callable
from pathlib import Path

from derod.errors import RecordError
from derod.frames import ROW, Ending, Event, Frame, Outcome
from derod.record.growing import GrowingFile, NoRoomError
from derod.record.reader import Run, open_run
from derod.scene import Scene


class RunWriter:
    """Writes every frame and event to an HDF5 run file, committed when the call returns.

    The file appears under its name only once it is readable, and is readable from then on, whether
    the process ends, is killed, or runs out of disk. Missing folders are made. An existing file
    is replaced only with ``overwrite``. Methods raise RecordError.
    """

    def __init__(self, path: str | os.PathLike[str], *, overwrite: bool = False) -> None:
        self.path = os.fspath(path)
        self._overwrite = overwrite
        self._file: GrowingFile | None = None
        self._last = float("nan")  # end-shortening

    def start(self, scene: Scene, first_increment: int) -> None:
        """Create the file, or check that the copied one ends where the push goes on."""
        if self._file is None:
            if first_increment != 0:
                raise RecordError(
                    f"{self.path}: a push that goes on at increment {first_increment} needs the "
                    "frames before it (see resume_copy)"
                )
            if not self._overwrite and os.path.lexists(self.path):
                raise RecordError(f"{self.path}: exists already")
            self._file = _create(self.path, scene, None)
        elif first_increment != self._file.frames:
            raise RecordError(
                f"{self.path}: has {self._file.frames} frames, but the push goes on at "
                f"increment {first_increment}"
            )

    def event(self, event: Event) -> None:
        """Commit ``event``."""
        self._guarded(lambda file: file.append_event(event))

    def frame(self, frame: Frame) -> None:
        """Commit ``frame``."""
        file = self._opened()
        row = frame.row
        shapes = {
            "positions": (frame.positions.shape, (file.nodes, 3)),
            "arc_length": (frame.arc_length.shape, (file.nodes,)),
            "drop_center": (frame.drop_center.shape, (3,)),
            "edge_tension": (frame.edge_tension.shape, (file.nodes - 1,)),
        }
        for name, (given, wanted) in shapes.items():
            if given != wanted:
                raise RecordError(f"{self.path}: {name} has shape {given}, not {wanted}")
        if row["increment"] != file.frames:
            raise RecordError(
                f"{self.path}: increment {row['increment']} follows frame {file.frames - 1}"
            )
        self._guarded(lambda file: file.append_frame(frame))
        self._last = float(row["end_shortening"])

    def finish(self, ending: Ending) -> None:
        """Write the ending and close; a second call, or one after a failed write, does nothing."""
        file, self._file = self._file, None
        if file is None:
            return
        try:
            file.write_ending(ending)
            file.close()
        except (OSError, RuntimeError) as error:
            file.abandon()
            raise RecordError(f"{self.path}: {_reason(error)}") from error

    def _opened(self) -> GrowingFile:
        if self._file is None:
            raise RecordError(f"{self.path}: is not open for writing")
        return self._file

    def _guarded(self, write: Callable[[GrowingFile], None]) -> None:
        """Run ``write``; when it fails leave a readable file that says so."""
        file = self._opened()
        try:
            if not file.is_at(self.path):
                raise GoneError("the file is gone: it or its folder was deleted, moved or replaced")
            write(file)
        except (OSError, RuntimeError) as error:
            self._file = None
            message = f"{self.path}: {_reason(error)}; {file.frames} frames are safe"
            _leave(file, error, Ending(Outcome.RECORD_FAILED, message, self._last))
            raise RecordError(message) from error


class GoneError(OSError):
    """The name of the file leads elsewhere, or nowhere."""


def resume_copy(path: str | os.PathLike[str], scene: Scene | None = None) -> RunWriter:
    """A writer that goes on after the last committed frame of the run file ``path``.

    The committed frames, and the events before them, are copied into a new file that then takes the
    place of the old one in one step; a file whose writer was killed is never appended to.
    ``scene`` replaces the recorded one, e.g. for a longer push; the mesh must stay.
    Raises RecordError.
    """
    with open_run(path) as run:
        scene = run.scene if scene is None else scene
        if run.table.dtype != ROW:
            raise RecordError(f"{run.path}: was written by another version, which cannot go on")
        if scene.mesh != run.scene.mesh:
            raise RecordError(f"{run.path}: a run cannot go on with another mesh")
        writer = RunWriter(path)
        writer._file = _create(writer.path, scene, run)  # a friend: the only other maker of writers
        if len(run):
            writer._last = float(run.table["end_shortening"][-1])
    return writer


def _create(path: str, scene: Scene, old: Run | None) -> GrowingFile:
    """A file under a passing name, with the frames of ``old``, then moved to ``path``."""
    folder, name = os.path.split(path)
    passing = os.path.join(folder, f".{name}.{os.getpid()}.part")  # noqa: PTH118
    file = None
    try:
        Path(folder).mkdir(parents=True, exist_ok=True)
        file = GrowingFile(passing, scene, None if old is None else old.created)
        if old is not None:
            file.copy(old)
        os.replace(passing, path)  # noqa: PTH105
    except BaseException as error:
        if file is not None:
            file.abandon()
        with contextlib.suppress(OSError):  # not there, or no way to it
            Path(passing).unlink()
        if isinstance(error, OSError | RuntimeError):
            raise RecordError(f"{path}: cannot be written: {_reason(error)}") from error
        raise
    return file


def _leave(file: GrowingFile, error: Exception, ending: Ending) -> None:
    """Close ``file`` after ``error`` as cleanly as it allows; the frames in it are safe anyway."""
    untouched = isinstance(error, NoRoomError | GoneError)  # HDF5 itself has not failed
    try:
        file.write_ending(ending)
        if untouched:
            file.close()
    except (OSError, RuntimeError):
        untouched = False  # the ending is lost, readers take the run for a killed one
    if not untouched:
        file.abandon()


def _reason(error: Exception) -> str:
    """What went wrong, in the words of the operating system where it was asked."""
    if isinstance(error, GoneError):
        return str(error)
    number = error.errno if isinstance(error, OSError) else None
    if number is None:  # HDF5 hides it in its message
        found = re.search(r"errno = ([0-9]+)", str(error))
        number = int(found[1]) if found else None
    return str(error).splitlines()[0] if number is None else os.strerror(number).lower()
