"""What is compiled in this process, and for how long: for those who wait, and clocks that leave it out."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

Listener = Callable[[str, bool], None]
"""Is told the name of a kernel of ours and whether it begins (True) or is done."""


class _Watch:
    """The one account of this process."""

    def __init__(self) -> None:
        self.depth = 0
        self.began = 0.0
        self.total = 0.0
        self.taken = 0.0
        self.kernels = 0
        self.listeners: list[Listener] = []
        self.registered = False
        self.ours: list[bool] = []

    def enter(self) -> None:
        if self.depth == 0:
            self.began = time.perf_counter()
        self.depth += 1

    def leave(self) -> None:
        self.depth -= 1
        if self.depth == 0:
            self.total += time.perf_counter() - self.began


_watch = _Watch()


def seconds() -> float:
    """Seconds that this process has spent on compiling, or on waiting for another one that compiles."""
    running = time.perf_counter() - _watch.began if _watch.depth else 0.0
    return _watch.total + running


def take() -> float:
    """The seconds since this was asked last: a push takes those spent for it, also before it began."""
    now = seconds()
    since, _watch.taken = now - _watch.taken, now
    return since


def kernels() -> int:
    """Kernels of ours that this process has compiled."""
    return _watch.kernels


def clock() -> float:
    """``time.perf_counter()`` without the seconds of compilation; its zero has no meaning."""
    return time.perf_counter() - seconds()


def listen(listener: Listener) -> None:
    """Let ``listener`` hear of every kernel of ours that is compiled from now on."""
    _watch.listeners.append(listener)


def forget(listener: Listener) -> None:
    """Let ``listener`` hear no more."""
    _watch.listeners.remove(listener)


class waiting:  # noqa: N801  a context, read like a verb
    """Counts the time inside as compilation: another process does it for us."""

    def __enter__(self) -> None:
        _watch.enter()

    def __exit__(self, *error: object) -> None:
        _watch.leave()


def watch_numba() -> None:
    """Begin the account; imports numba."""
    from numba.core import event

    if _watch.registered:
        return

    class Compilation(event.Listener):
        def on_start(self, event: Any) -> None:
            _watch.enter()
            _watch.ours.append(is_ours(event.data["dispatcher"]))
            self._tell(event, True)

        def on_end(self, event: Any) -> None:
            if is_ours(event.data["dispatcher"]):
                _watch.kernels += 1
            self._tell(event, False)
            _watch.ours.pop()
            _watch.leave()

        def _tell(self, event: Any, begins: bool) -> None:
            dispatcher = event.data["dispatcher"]
            if is_ours(dispatcher):
                for listener in _watch.listeners:
                    listener(dispatcher.py_func.__name__, begins)

    event.register("numba:compile", Compilation())
    _watch.registered = True


def is_at_ours() -> bool:
    """Whether a kernel of ours is compiled just now, and what it calls."""
    return bool(_watch.ours) and _watch.ours[0]


def is_ours(dispatcher: Any) -> bool:
    """Whether a numba dispatcher is one of this package's kernels."""
    return str(dispatcher.py_func.__module__).partition(".")[0] == __name__.partition(".")[0]
