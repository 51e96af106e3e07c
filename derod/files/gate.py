"""The gate through which HDF5 sees a file that is read: bytes that are there, in bounded time.

HDF5's own way of reading a live file has two faults that no setting mends: it takes what lies beyond the
end for zeros, and it tries a damaged block again and again with doubling pauses. So a file is read as a
finished one, whose first bytes, as HDF5 is shown them, say that it ends where it ends now. What a
writer commits meanwhile is seen when the file is opened again.

The gate reads one file, by its descriptor. HDF5 cannot write through it.
"""

from __future__ import annotations

import atexit
import os
import stat
import time
import weakref
from typing import Any

import h5py

from derod.errors import RecordError
from derod.files import superblock

PATIENCE = 3.0  # s that opening, or reading one thing, may take
SLOWEST = 20e6  # bytes/s expected of a disk, beyond that
MOST_READS = 20_000  # to open a file: ours take fewer than 100
_open: weakref.WeakSet[Gate] = weakref.WeakSet()


class Gate:
    """A file as Python's file objects are, for h5py's driver of such; methods raise OSError."""

    def __init__(self, path: str | int) -> None:
        """Open ``path``, or a file that is open by its descriptor.

        Raises OSError, and NotOursError for what is no HDF5 file of ours.
        """
        flags = os.O_RDONLY | os.O_CLOEXEC | os.O_NONBLOCK | os.O_NOCTTY
        self.descriptor = os.dup(path) if isinstance(path, int) else os.open(path, flags)
        try:
            self.stat = os.fstat(self.descriptor)
            if not stat.S_ISREG(self.stat.st_mode):
                raise superblock.NotOursError("it is no regular file")
            self.size = self.stat.st_size
            self.block = superblock.unpack(os.pread(self.descriptor, superblock.SIZE, 0))
            if not self.block.live and self.size < self.block.end:
                raise superblock.NotOursError(
                    f"its end is missing: it has {self.size} of {self.block.end} bytes"
                )
        except BaseException:
            self.close()
            raise
        self._head = self.block._replace(flags=0, end=self.size).pack()
        self.file: h5py.File | None = None
        self._position = 0
        self.allow(0)

    def allow(self, size: int) -> None:
        """Begin something that reads about ``size`` bytes: from now on time and reads are counted."""
        self._deadline = time.monotonic() + PATIENCE + size / SLOWEST
        self._reads_left = MOST_READS + size // 512

    def seek(self, offset: int, whence: int = os.SEEK_SET) -> int:
        """Go to ``offset``."""
        self._position = offset + (self.size if whence == os.SEEK_END else 0)
        return self._position

    def tell(self) -> int:
        """Where the next reading begins."""
        return self._position

    def readinto(self, buffer: Any) -> int:
        """Fill ``buffer``; raises OSError where the file has no so many bytes."""
        self._reads_left -= 1
        if self._reads_left < 0 or time.monotonic() > self._deadline:
            raise OSError("it leads HDF5 in circles")
        start, wanted = self._position, len(buffer)
        data = os.pread(self.descriptor, wanted, start)
        if len(data) < wanted:
            raise OSError(f"its end is missing: bytes {start} to {start + wanted} are not there")
        if start < superblock.SIZE:
            data = (self._head[start:] + data[superblock.SIZE - start :])[:wanted]
        buffer[:wanted] = data
        self._position += wanted
        return wanted

    def read(self, size: int = -1) -> bytes:
        """The next ``size`` bytes."""
        data = bytearray(self.size - self._position if size < 0 else size)
        self.readinto(data)
        return bytes(data)

    def write(self, data: Any) -> int:
        """Refuse."""
        raise OSError("it is open for reading only")

    def truncate(self, size: int | None = None) -> int:
        """Do nothing: HDF5 asks for it when it closes."""
        return self.size

    def flush(self) -> None:
        """Do nothing."""

    def shut(self) -> None:
        """Close what HDF5 opened through the gate, then the gate."""
        file, self.file = self.file, None
        if file is not None:
            file.close()
        self.close()

    def close(self) -> None:
        """Let go of the file."""
        if self.descriptor >= 0:
            os.close(self.descriptor)
            self.descriptor = -1

    def __del__(self) -> None:
        self.close()


def open_gate(
    path: str, what: str = "a run file", descriptor: int | None = None
) -> tuple[Gate, h5py.File]:
    """Open ``path`` for reading; raises RecordError with one line that says why not.

    With ``descriptor`` the file is the one behind that, wherever its name has gone.
    """
    if descriptor is None and not os.path.isfile(path):  # noqa: PTH113  no error for any name
        raise RecordError(f"{path}: there is no such file")
    try:
        gate = Gate(path if descriptor is None else descriptor)
    except superblock.OtherKindError as error:
        raise RecordError(f"{path}: is not {what} of derod: {error}") from error
    except (OSError, ValueError) as error:
        raise RecordError(f"{path}: cannot be read as {what}: {reason(error)}") from error
    try:
        file = h5py.File(gate, "r", rdcc_nbytes=0)
    except (OSError, RuntimeError, ValueError) as error:
        gate.close()
        raise RecordError(f"{path}: cannot be read as {what}: {reason(error)}") from error
    gate.file = file
    _open.add(gate)
    return gate, file


def reason(error: BaseException) -> str:
    """An error's first line, in the operating system's words where they are its own."""
    if isinstance(error, OSError) and error.strerror and error.errno:
        return error.strerror.lower()
    return (str(error).splitlines() or [type(error).__name__])[0]


@atexit.register
def _close_all() -> None:
    """Close what is open while there is still a Python to call: HDF5 would close it later."""
    for gate in list(_open):
        gate.shut()
