"""One rule for every file that derod writes.

An existing file is replaced only where that was asked for. An output that is also an input, or another
output, is refused, and so is whatever is no regular file: a device, a pipe, a folder. Links are
followed: the file they name is replaced, by a new one made beside it and moved into its place in one step,
with the old one's mode. A write-protected file is not replaced. Refusals come before any work.

The new file has a passing name, ``.NAME.PID.part``, and its writer's lock. What killed writers left is
removed by the next one.
"""

from __future__ import annotations

import contextlib
import os
import re
import stat
import time
from collections.abc import Iterable, Iterator
from pathlib import Path

from derod.errors import DerodError, RecordError
from derod.files.lock import Lock, is_locked

ASK = "--force replaces it"
YOUNG = 60.0  # s; the passing file of a live process may not be locked yet
AnyPath = str | os.PathLike[str]


class OutputError(RecordError):
    """A file that cannot be written."""


class RefusedError(OutputError):
    """A file that must not be written."""


def check_output(
    path: AnyPath,
    *,
    force: bool = False,
    inputs: Iterable[AnyPath | None] = (),
    others: Iterable[AnyPath | None] = (),
    ask: str = ASK,
    make_folders: bool = True,
) -> Path:
    """Return the file that writing to ``path`` shall make or replace, links followed.

    ``inputs`` are files that are read, ``others`` those that are written beside it. Raises InUseError
    where another process writes it, RefusedError and OutputError: one line that names the path, what is
    wrong and what is allowed.
    """
    name = os.fsdecode(os.fspath(path))
    try:
        target = _target(name)
        for other in inputs:
            if other is not None and is_same(target, other):
                raise RefusedError(f"{name}: is read, and cannot be written too; give another name")
        for other in others:
            if other is not None and is_same(target, other):
                raise RefusedError(f"{name}: is written twice; give two names")
        _check_target(name, target, force, ask)
        _check_folder(name, target.parent, make_folders)
    except (OSError, ValueError, RuntimeError) as error:
        raise OutputError(f"{name}: cannot be written: {words(error)}") from error
    return target


def _target(name: str) -> Path:
    if not name or name.endswith(os.sep) or Path(name).name in ("", ".", ".."):
        raise RefusedError(f"{name or 'an empty name'}: is no name of a file")
    if "\0" in name:
        raise RefusedError(f"{name}: is no name of a file: it has a null character")
    return Path(os.path.realpath(name))


def _check_target(name: str, target: Path, force: bool, ask: str) -> None:
    if target.is_symlink():
        raise RefusedError(f"{name}: is a link that leads in a circle")
    try:
        there = target.stat()
    except FileNotFoundError:
        if os.path.lexists(name) and not force:  # a link that leads nowhere yet
            raise RefusedError(f"{name}: exists already; {ask}") from None
        return
    if not stat.S_ISREG(there.st_mode):
        kind = _kind(there.st_mode)
        raise RefusedError(f"{name}: cannot be written: it is {kind}; allowed: a regular file")
    if not force:
        with contextlib.suppress(OSError):  # not ours to write: then nobody's lock can be seen
            Lock.take(str(target)).release()  # who writes it is the better answer
        raise RefusedError(f"{name}: exists already; {ask}")
    if not there.st_mode & 0o222 or not os.access(target, os.W_OK):
        raise RefusedError(f"{name}: is write-protected")


def _check_folder(name: str, folder: Path, make: bool) -> None:
    if not make and not folder.is_dir():
        raise RefusedError(f"{name}: no such folder; allowed: a file in an existing folder")
    while not os.path.lexists(folder):  # folders that are missing are made
        folder = folder.parent
    if not folder.is_dir():
        raise OutputError(f"{name}: cannot be written: not a directory")
    if not os.access(folder, os.W_OK | os.X_OK):
        raise OutputError(f"{name}: cannot be written: permission denied")


def _kind(mode: int) -> str:
    if stat.S_ISDIR(mode):
        return "a folder"
    if stat.S_ISFIFO(mode):
        return "a pipe"
    return "a device" if stat.S_ISCHR(mode) or stat.S_ISBLK(mode) else "no regular file"


def is_same(one: AnyPath, other: AnyPath) -> bool:
    """Whether two names lead to one file, which need not exist."""
    if os.path.realpath(one) == os.path.realpath(os.fspath(other)):
        return True
    try:
        return os.path.samefile(one, other)  # noqa: PTH121
    except OSError:
        return False


def passing_name(target: Path) -> Path:
    """The name under which this process makes the file ``target``."""
    return target.with_name(f".{target.name}.{os.getpid()}.part")


def sweep(target: Path) -> None:
    """Remove the passing files that killed writers of ``target`` left."""
    pattern = re.compile(rf"\.{re.escape(target.name)}\.([0-9]+)\.part")
    try:
        entries = [entry.name for entry in os.scandir(target.parent)]
    except OSError:
        return  # no such folder yet
    for name in entries:
        found = pattern.fullmatch(name)
        if found is None or int(found[1]) == os.getpid():
            continue
        part = target.with_name(name)
        with contextlib.suppress(OSError, DerodError):  # gone, or not ours to remove
            if not stat.S_ISREG(part.lstat().st_mode) or is_locked(str(part)):
                continue
            young = time.time() - part.lstat().st_mtime < YOUNG
            if not (young and is_alive(int(found[1]))):
                part.unlink()


def is_alive(pid: int) -> bool:
    """Whether a process of that number runs on this machine."""
    try:
        os.kill(pid, 0)
    except (ProcessLookupError, OverflowError):
        return False
    except PermissionError:
        return True
    return True


def publish(passing: Path, target: Path, held: Lock | None = None) -> None:
    """Give a finished file its name: in the place of the file that ``held`` has locked, or of none.

    A file that came meanwhile, where there was none, stays. Raises FileExistsError, OSError.
    """
    if held is not None:
        old = os.fstat(held.descriptor)
        if (old.st_uid, old.st_gid) != (os.geteuid(), os.getegid()):
            with contextlib.suppress(PermissionError):  # another's file: then it becomes ours
                os.chown(passing, old.st_uid, old.st_gid)
        passing.chmod(stat.S_IMODE(old.st_mode))
        passing.replace(target)
        return
    try:
        os.link(passing, target)
    except FileExistsError:
        raise
    except OSError as error:  # a file system without hard links
        if os.path.lexists(target):
            raise FileExistsError(f"{target}: exists already") from error
        passing.replace(target)
        return
    passing.unlink()


@contextlib.contextmanager
def replacing(path: AnyPath, *, force: bool = False) -> Iterator[Path]:
    """A passing file to write; it takes the place of ``path`` when the block ends well.

    For files that are written in one go. Raises OutputError, InUseError; the old file then stays.
    """
    target = check_output(path, force=force)
    held = None
    passing = passing_name(target)
    try:
        target.parent.mkdir(parents=True, exist_ok=True)
        sweep(target)
        if target.exists():
            held = Lock.take(str(target))
        passing.unlink(missing_ok=True)
        with Lock.make(str(passing)):
            yield passing
            publish(passing, target, held)
    except OSError as error:
        raise OutputError(f"{path}: cannot be written: {words(error)}") from error
    finally:
        if held is not None:
            held.release()
        with contextlib.suppress(OSError):
            passing.unlink(missing_ok=True)


def words(error: Exception) -> str:
    """What went wrong, in the operating system's words where they are its own."""
    text = error.strerror if isinstance(error, OSError) and error.strerror else str(error)
    return (text.lower().splitlines() or [type(error).__name__])[0]
