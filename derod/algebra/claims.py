"""One process compiles a kernel, the others wait for it and load it.

Processes that start together on an empty cache would each compile every kernel. So a kernel is claimed
before it is looked up: a lock on a file beside its index, which ends with its owner however that ends. The
claim also covers numba's reading, changing and writing of the index, which by itself is no transaction: of
two processes that keep the same function for other types, one would lose its entry, or find the other's
code under it.

Kernels call each other without cycles, so nobody waits for whom he keeps waiting. A claim that cannot be
had, on a file system without locks or after ``PATIENCE``, is done without.
"""

from __future__ import annotations

import contextlib
import errno
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from derod.algebra import compiling

try:
    import fcntl
except ImportError:  # Windows: every process compiles for itself, as numba would
    fcntl = None  # type: ignore[assignment]

SUFFIX = ".claim"
PATIENCE = 600.0  # s, after which one compiles by oneself
LOOK_AGAIN = 0.01  # s
_held: set[str] = set()


def claim_kernels() -> None:
    """Have this process claim the kernels of our cache before it loads or compiles them; imports numba."""
    from numba.core.compiler_lock import global_compiler_lock
    from numba.core.dispatcher import Dispatcher

    if hasattr(Dispatcher.compile, "claims"):
        return
    without = Dispatcher.compile

    def compile(self: Any, sig: Any) -> Any:  # noqa: A001  numba's name
        path = claim_path(self)
        if path is None or (isinstance(sig, tuple) and sig in self.overloads):
            return without(self, sig)
        with (
            global_compiler_lock,
            claimed(path),
        ):  # in this order: a thread of ours may hold the lock
            return without(self, sig)

    setattr(compile, "claims", True)  # noqa: B010
    setattr(Dispatcher, "compile", compile)  # noqa: B010  a method, to mypy


def claim_path(dispatcher: Any) -> Path | None:
    """The file whose lock is the claim to a kernel; None for what does not lie in our cache."""
    from derod.algebra.mending import is_in_our_cache

    file = getattr(getattr(dispatcher, "_cache", None), "_cache_file", None)
    if file is None or not is_in_our_cache(file._cache_path):
        return None
    return Path(file._index_path).with_suffix(SUFFIX)


@contextlib.contextmanager
def claimed(path: Path) -> Iterator[None]:
    """Hold the claim at ``path``, once another process that has it is done."""
    if fcntl is None or str(path) in _held:
        yield
        return
    with contextlib.ExitStack() as stack:
        file = _opened(path)
        if file is not None:
            stack.callback(file.close)
            if not _lock(file):
                with compiling.waiting():
                    _wait(file)
        _held.add(str(path))
        stack.callback(_held.discard, str(path))
        yield


def is_claimed_elsewhere(path: Path) -> bool:
    """Whether another process is at the kernel just now."""
    if fcntl is None or str(path) in _held:
        return False
    file = _opened(path)
    if file is None:
        return False
    with file:
        return not _lock(file)


def _opened(path: Path) -> Any:
    try:
        return path.open("ab")
    except OSError:  # the folder is gone, or read-only: numba will say so if it matters
        return None


def _lock(file: Any) -> bool:
    """Take the lock; False where another process has it."""
    try:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError as error:
        return error.errno not in (errno.EWOULDBLOCK, errno.EAGAIN, errno.EACCES)
    return True


def _wait(file: Any) -> None:
    end = time.monotonic() + PATIENCE
    while not _lock(file) and time.monotonic() < end:
        time.sleep(LOOK_AGAIN)
