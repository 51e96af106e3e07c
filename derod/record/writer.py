"""The observer that keeps a push in a run file, and the way back into a file to go on."""

from __future__ import annotations

import contextlib
import os
import re
from collections.abc import Callable, Iterator
from pathlib import Path

from derod.errors import RecordError
from derod.files.lock import Lock
from derod.files.outputs import check_output, passing_name, publish, sweep
from derod.pushing.frames import Ending, Event, Frame, Outcome
from derod.record.growing import GrowingFile, NoRoomError
from derod.record.reader import Run, open_run
from derod.record.verify import verify_head
from derod.scene import Scene


class RunWriter:
    """Writes every frame and event to an HDF5 run file, committed when the call returns.

    The file appears under its name only once it is readable, and is readable from then on, whether
    the process ends, is killed, or runs out of disk. Missing folders are made. An existing file
    is replaced only with ``overwrite``. Methods raise RecordError. ``began`` tells whether it is there.
    """

    def __init__(self, path: str | os.PathLike[str], *, overwrite: bool = False) -> None:
        self.path = os.fsdecode(os.fspath(path))
        self._overwrite = overwrite
        self._file: GrowingFile | None = None
        self._last = float("nan")  # end-shortening
        self.began = False

    def start(self, scene: Scene, first_increment: int) -> None:
        """Create the file, or check that the copied one ends where the push goes on."""
        if self._file is None:
            if first_increment != 0:
                raise RecordError(
                    f"{self.path}: a push that goes on at increment {first_increment} needs the "
                    "frames before it (see resume_copy)"
                )
            target = check_output(self.path, force=self._overwrite)
            with _held_if_there(target) as held:
                self._file = _create(self.path, target, scene, None, held)
            self.began = True
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
        if frame.edge_frame is not None:
            shapes["edge_frame"] = (frame.edge_frame.shape, (file.nodes - 1, 7))
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
                raise GoneError(
                    "the file is gone: it or its folder was deleted, moved or replaced, with "
                    f"{file.frames} frames"
                )
            write(file)
        except (OSError, RuntimeError) as error:
            self._file = None
            safe = 0 if isinstance(error, GoneError) else file.frames
            message = f"{self.path}: {_reason(error)}; {safe} frames are safe"
            _leave(file, error, Ending(Outcome.RECORD_FAILED, message, self._last))
            raise RecordError(message) from error


class GoneError(OSError):
    """The name of the file leads elsewhere, or nowhere."""


def resume_copy(
    path: str | os.PathLike[str], scene: Scene | None = None, lock: Lock | None = None
) -> RunWriter:
    """A writer that goes on after the last committed frame of the run file ``path``.

    The committed frames, and the events before them, are held against their checksums and copied into a
    new file that then takes the place of the old one in one step; a file whose writer was killed is
    never appended to. ``scene`` replaces the recorded one, e.g. for a longer push; the mesh must stay.
    ``lock`` is the file's, where the caller holds it already. Raises RecordError, InUseError where
    another process writes the file.
    """
    with contextlib.ExitStack() as stack:
        held = stack.enter_context(locked(path)) if lock is None else lock
        run = stack.enter_context(open_run(path))
        if run.checksummed:
            verify_head(run)
        scene = run.scene if scene is None else scene
        if scene.mesh != run.scene.mesh:
            raise RecordError(f"{run.path}: a run cannot go on with another mesh")
        writer = RunWriter(path)
        target = check_output(path, force=True)
        # a friend: the only other maker of writers
        writer._file = _create(writer.path, target, scene, run, held)
        if len(run):
            writer._last = float(run.table["end_shortening"][-1])
    return writer


def locked(path: str | os.PathLike[str]) -> Lock:
    """The lock of the run file ``path``, which must be there and not be write-protected.

    Raises RecordError, InUseError.
    """
    name = os.fsdecode(os.fspath(path))
    if not os.path.isfile(name):  # noqa: PTH113
        raise RecordError(f"{name}: there is no such file")
    target = check_output(name, force=True)
    try:
        return Lock.take(str(target))
    except OSError as error:
        raise RecordError(f"{name}: cannot be written: {_reason(error)}") from error


@contextlib.contextmanager
def _held_if_there(target: Path) -> Iterator[Lock | None]:
    """The lock of a file that shall be replaced; None where there is none yet."""
    try:
        held = Lock.take(str(target)) if target.exists() else None
    except FileNotFoundError:
        held = None
    except OSError as error:
        raise RecordError(f"{target}: cannot be written: {_reason(error)}") from error
    try:
        yield held
    finally:
        if held is not None:
            held.release()


def _create(
    path: str, target: Path, scene: Scene, old: Run | None, held: Lock | None
) -> GrowingFile:
    """A file under a passing name, with the frames of ``old``, then moved to ``target``.

    ``held`` is the lock of the file whose place it takes.
    """
    passing = passing_name(target)
    file = None
    try:
        target.parent.mkdir(parents=True, exist_ok=True)
        sweep(target)
        passing.unlink(missing_ok=True)
        file = GrowingFile(str(passing), scene, None if old is None else old.created)
        if old is not None:
            file.copy(old)
        publish(passing, target, held)
    except BaseException as error:
        if file is not None:
            file.abandon()
        with contextlib.suppress(OSError):  # not there, or no way to it
            passing.unlink()
        if isinstance(error, FileExistsError):  # it came between the look and the move
            raise _taken(path, target) from error
        if isinstance(error, OSError | RuntimeError):
            raise RecordError(f"{path}: cannot be written: {_reason(error)}") from error
        raise
    return file


def _taken(path: str, target: Path) -> RecordError:
    """Why a name cannot be had that another writer took a moment ago."""
    try:
        Lock.take(str(target)).release()
    except RecordError as error:
        return error
    except OSError:
        return RecordError(f"{path}: exists already")
    return RecordError(f"{path}: exists already")


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
