"""Signals that end a command: one line, the exit code 128 + n, and an ending in the file.

SIGINT, SIGTERM and SIGHUP raise ``Interrupted`` where Python happens to be. Of a storm of signals only the
first one does: the others must not disturb the writing of the ending. But an exception raised inside a
callback from C, as when LLVM compiles, may be swallowed or come back as another one. So the signal is
raised again every second until somebody has acknowledged it, and whatever was raised meanwhile counts as
the interruption.
"""

from __future__ import annotations

import contextlib
import signal
import sys
import threading
import time
from collections.abc import Iterator
from types import FrameType
from typing import Any

AGAIN = 1.0  # s
SIGNALS = ("SIGINT", "SIGTERM", "SIGHUP")


class Interrupted(KeyboardInterrupt):
    """A signal that ends the command."""


class _Seen:
    """What has come so far."""

    number: int | None = None
    raised = 0.0
    acknowledged = False


_seen = _Seen()


def pending() -> int | None:
    """The number of the signal that has come, or None."""
    return _seen.number


def acknowledge() -> None:
    """Say that the command is ending: from now on signals are ignored."""
    if _seen.number is not None:
        _seen.acknowledged = True


def words() -> str:
    """Who interrupted."""
    number = _seen.number
    return "interrupted" if number is None else f"interrupted by {signal.Signals(number).name}"


def exit_code() -> int:
    """128 and the number of the signal; that of Ctrl-C where none was seen."""
    return 128 + (signal.SIGINT if _seen.number is None else _seen.number)


def _handle(number: int, frame: FrameType | None) -> None:
    now = time.monotonic()
    if _seen.acknowledged or (_seen.number is not None and now - _seen.raised < 0.9 * AGAIN):
        return
    if number == signal.SIGALRM:
        if _seen.number is None:
            return
    elif _seen.number is None:
        _seen.number = number
    _seen.raised = now
    signal.setitimer(signal.ITIMER_REAL, AGAIN)
    raise Interrupted


def _unraisable(before: Any) -> Any:
    def hook(arguments: Any) -> None:
        if not (_seen.number is not None and arguments.exc_type is Interrupted):
            before(arguments)

    return hook


@contextlib.contextmanager
def signals(*, leaving: bool = False) -> Iterator[None]:
    """Let signals end what happens inside; those that are ignored (``nohup``) stay ignored.

    With ``leaving`` the process ends afterwards: what is left of a storm does nothing then.
    """
    if threading.current_thread() is not threading.main_thread():
        yield  # signals go to the main thread only
        return
    _seen.number, _seen.raised, _seen.acknowledged = None, 0.0, False
    numbers = [getattr(signal, name) for name in SIGNALS if hasattr(signal, name)]
    before = {number: signal.getsignal(number) for number in (*numbers, signal.SIGALRM)}
    hook = sys.unraisablehook
    sys.unraisablehook = _unraisable(hook)
    try:
        for number, handler in before.items():
            if handler is not signal.SIG_IGN:
                signal.signal(number, _handle)
        yield
    finally:
        _seen.acknowledged = True
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        for number, handler in before.items():
            if leaving and _seen.number is not None:
                signal.signal(number, signal.SIG_IGN)
            elif handler is not None:
                signal.signal(number, handler)
        sys.unraisablehook = hook
