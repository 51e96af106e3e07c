"""A one-way pipe of objects to a child process that never makes the sender wait.

What the child does not take at once is kept up to a limit and dropped beyond it. The child answers
every message with a byte, its heartbeat; a child without a heartbeat is given up.
"""

from __future__ import annotations

import os
import pickle
import select
import subprocess
import sys
import time
from collections import deque
from contextlib import suppress
from typing import IO, cast

MOST_BACKLOG = 128 * 2**20  # bytes
PIPE_SIZE = 2**20
F_SETPIPE_SZ = 1031  # Linux


class Pipe:
    """Sends objects to ``python -m MODULE``, which reads pickles from its standard input."""

    def __init__(self, module: str, most_backlog: int = MOST_BACKLOG) -> None:
        self.dropped = 0
        self.broken = False
        self._most = most_backlog
        self._backlog: deque[memoryview] = deque()
        self._size = 0
        self.child = subprocess.Popen(
            [sys.executable, "-m", module],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            start_new_session=True,  # our Ctrl-C is not the child's
            env=os.environ | {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"},
        )
        self._input, self._output = (
            cast(IO[bytes], self.child.stdin),
            cast(IO[bytes], self.child.stdout),
        )
        self._into, self._from = self._input.fileno(), self._output.fileno()
        os.set_blocking(self._into, False)
        os.set_blocking(self._from, False)
        _enlarge(self._into)

    def send(self, message: object, *, must: bool = False) -> None:
        """Hand over a message; one that finds no room is dropped, unless it ``must`` arrive."""
        if self.broken:
            return
        data = pickle.dumps(message, protocol=pickle.HIGHEST_PROTOCOL)
        if self._size + len(data) > self._most and not must:
            self.dropped += 1
            self.pump()
            return
        self._backlog.append(memoryview(data))
        self._size += len(data)
        self.pump()

    def pump(self) -> bool:
        """Write what the child takes and read its heartbeats; return whether it did anything."""
        moved = False
        with suppress(BlockingIOError):
            moved = bool(os.read(self._from, 65536))
        while self._backlog and not self.broken:
            try:
                done = os.write(self._into, self._backlog[0])
            except BlockingIOError:
                break
            except OSError:  # it has ended
                self.broken = True
                break
            moved = moved or done > 0
            self._size -= done
            if done < len(self._backlog[0]):
                self._backlog[0] = self._backlog[0][done:]
            else:
                self._backlog.popleft()
        return moved

    def drain(self, patience: float) -> bool:
        """Wait until the child has taken everything and ended; False if it had to be given up.

        It may take its time as long as it does something at least every ``patience`` seconds.
        """
        last = time.monotonic()
        while self._backlog and not self.broken:
            select.select([self._from], [self._into], [], 0.05)
            now = time.monotonic()
            if self.pump():
                last = now
            elif now - last > patience:
                return self.give_up()
            if self.child.poll() is not None:
                break
        self._close_input()
        last = time.monotonic()
        while self.child.poll() is None:
            ready, _, _ = select.select([self._from], [], [], 0.02)
            now = time.monotonic()
            if ready and os.read(self._from, 65536):
                last = now
            elif now - last > patience:
                return self.give_up()
            elif ready:  # end of file: it is about to end
                time.sleep(0.005)
        self._close_output()
        return self.child.returncode == 0

    def give_up(self) -> bool:
        """End a child that does nothing any more."""
        self.broken = True
        self.child.kill()
        self.child.wait()
        self._close_input()
        self._close_output()
        return False

    def _close_input(self) -> None:
        try:
            self._input.close()
        except OSError:  # it has ended
            self.broken = True

    def _close_output(self) -> None:
        self._output.close()


def _enlarge(descriptor: int) -> None:
    """Let the pipe hold a megabyte where the system can, so that short pushes never meet a full
    one.
    """
    if sys.platform != "linux":
        return
    import fcntl

    try:
        fcntl.fcntl(descriptor, F_SETPIPE_SZ, PIPE_SIZE)
    except OSError:  # more than this user may have: the backlog serves as well
        return
