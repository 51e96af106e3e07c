"""One writer a file: a lock that dies with its owner and tells the owner's process number.

It is a POSIX lock on bytes far behind the end of the file itself, owned by an open file description
(``F_OFD_SETLK``): no file is left beside the run, closing another descriptor of the file does not let go
of it, and HDF5's own locks (``flock``) do not meet it. The locked bytes are ``FIRST`` to ``FIRST + pid``:
all locks share the first one, so that they exclude each other, and their length tells whose they are,
also over NFS (versions 3 with lockd, and 4). Where the system has no such locks (not Linux, or a file
system that refuses), the file is written without one.
"""

from __future__ import annotations

import contextlib
import errno
import fcntl
import os
import stat
import struct
import weakref
from pathlib import Path
from typing import Self

from derod.errors import InUseError, RecordError

FIRST = 2**62
TRIES = 20
_FLOCK = struct.Struct("@hhqqi4x")  # l_type, l_whence, l_start, l_len, l_pid of 64-bit Linux
_HELD = (errno.EACCES, errno.EAGAIN)
_held: weakref.WeakSet[Lock] = weakref.WeakSet()


class Lock:
    """The right to write the file that a name leads to, until ``release`` or the end of the process."""

    def __init__(self, descriptor: int, target: Path) -> None:
        self.descriptor, self.target = descriptor, target
        _held.add(self)

    @classmethod
    def take(cls, path: str) -> Self:
        """Lock the regular file at ``path``, links followed.

        Raises InUseError, which names the owner's process number, and OSError where the file cannot
        be opened for writing.
        """
        for _ in range(TRIES):
            flags = os.O_RDWR | os.O_CLOEXEC | os.O_NONBLOCK | os.O_NOCTTY
            descriptor = os.open(path, flags)
            try:
                here = os.fstat(descriptor)
                if not stat.S_ISREG(here.st_mode):
                    raise RecordError(f"{path}: is no regular file")
                lock_descriptor(descriptor, path)
                if os.path.samestat(here, os.stat(path)):  # noqa: PTH116
                    return cls(descriptor, Path(path))
            except FileNotFoundError:  # moved away meanwhile
                os.close(descriptor)
                raise
            except BaseException:
                os.close(descriptor)
                raise
            os.close(descriptor)  # another file took its place meanwhile: that one counts
        raise RecordError(f"{path}: is replaced again and again by others")

    @classmethod
    def make(cls, path: str, mode: int = 0o666) -> Self:
        """Make the file ``path``, which must not exist, and lock it; raises OSError."""
        descriptor = os.open(path, os.O_RDWR | os.O_CREAT | os.O_EXCL | os.O_CLOEXEC, mode)
        try:
            lock_descriptor(descriptor, path)
            return cls(descriptor, Path(path))
        except BaseException:
            os.close(descriptor)
            raise

    def is_at(self, path: Path) -> bool:
        """Whether ``path`` leads to the file that is locked."""
        try:
            return os.path.samestat(os.fstat(self.descriptor), path.stat())
        except OSError:
            return False

    def release(self) -> None:
        """Let go; a second call does nothing."""
        descriptor, self.descriptor = self.descriptor, -1
        if descriptor >= 0:
            os.close(descriptor)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.release()

    def __del__(self) -> None:
        self.release()


def lock_descriptor(descriptor: int, path: str) -> None:
    """Lock the file of ``descriptor`` without waiting; raises InUseError."""
    if not hasattr(fcntl, "F_OFD_SETLK"):
        return
    wanted = _FLOCK.pack(fcntl.F_WRLCK, os.SEEK_SET, FIRST, 1 + os.getpid(), 0)
    try:
        fcntl.fcntl(descriptor, fcntl.F_OFD_SETLK, wanted)
    except OSError as error:
        if error.errno in _HELD:
            raise InUseError(f"{path}: is being written by {owner(descriptor)}") from error
        if error.errno not in (errno.EINVAL, errno.ENOLCK, errno.ENOTSUP, errno.ENOSYS):
            raise


def owner(descriptor: int) -> str:
    """Whose lock is in the way, in words."""
    asked = _FLOCK.pack(fcntl.F_WRLCK, os.SEEK_SET, FIRST, 1, 0)
    kind, _, start, length, _ = _FLOCK.unpack(fcntl.fcntl(descriptor, fcntl.F_OFD_GETLK, asked))
    if kind == fcntl.F_UNLCK or start != FIRST or length < 1:
        return "another process"  # which has just let go, or is no derod
    return f"process {length - 1}"


def is_locked(path: str) -> bool:
    """Whether somebody holds the lock of the file at ``path``; raises OSError."""
    try:
        Lock.take(path).release()
    except InUseError:
        return True
    return False


def _forget() -> None:
    """Let a forked child hold no lock: it would outlive its owner."""
    for lock in list(_held):
        with contextlib.suppress(OSError):
            lock.release()


os.register_at_fork(after_in_child=_forget)
