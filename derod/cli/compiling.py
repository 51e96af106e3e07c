"""Kernels made ready before a push, in two processes where there are two cores, and said so.

A survey (``derod.algebra.survey``) says which kernels a scene's first increments need. What is in no cache
is compiled here and, at the same time, by a helper process (``derod.cli.helper``) into the same cache;
claims keep the two from doing the same (``derod.algebra.claims``). The helper goes on with the kernels of
folds and unstable states while the push is under way, and ends with it.
"""

from __future__ import annotations

import contextlib
import json
import os
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, TextIO

from derod.errors import printable
from derod.terminal import say

if TYPE_CHECKING:
    from derod.algebra.survey import Wanted
    from derod.pushing.exercise import Variant
    from derod.scene import Scene

LINE_EVERY = 2.0  # s, off a terminal
READY = (
    "ready.json"  # in the cache folder: names of the variants whose first kernels were all there
)
GOODBYE = 2.0  # s that a helper is given to end


class Words:
    """Says how far the compilation is: in one line on a terminal, elsewhere in a line now and then."""

    def __init__(self, total: int, stream: TextIO | None = None) -> None:
        self.total = total
        self.stream = sys.stderr if stream is None else stream
        self.done: set[str] = set()
        self.busy: dict[str, float] = {}
        self.shown = -LINE_EVERY
        self.width = 0
        self.lock = threading.Lock()

    def __call__(self, name: str, begins: bool) -> None:
        """Take in that a kernel begins, or is done, in this process or in the helper."""
        with self.lock:
            if begins:
                self.busy[name] = time.monotonic()
            else:
                self.busy.pop(name, None)
                self.done.add(name)
            if begins or self.on_terminal():
                self.show()

    def on_terminal(self) -> bool:
        """Whether the words can be written over."""
        return self.stream is not None and self.stream.isatty()

    def show(self) -> None:
        """Print how far it is."""
        now = time.monotonic()
        if not self.on_terminal() and now - self.shown < LINE_EVERY:
            return
        self.shown = now
        count = min(len(self.done) + 1, self.total)
        of = f"{count} of {self.total}" if self.total else str(len(self.done) + 1)
        names = f" ({', '.join(sorted(self.busy))})" if self.busy else ""
        self._print(f"compiling kernels, {of}{names}")

    def clear(self) -> None:
        """Take the line off a terminal."""
        if self.on_terminal() and self.width:
            self._write("\r" + " " * self.width + "\r")
            self.width = 0

    def _print(self, text: str) -> None:
        text = printable(text)
        if self.on_terminal():
            self._write("\r" + text.ljust(self.width))
            self.width = len(text)
        else:
            say(text)

    def _write(self, text: str) -> None:
        with contextlib.suppress(OSError, ValueError):  # nobody reads remarks: see terminal.say
            self.stream.write(text)
            self.stream.flush()


class Helper:
    """A process that compiles kernels into our cache beside this one."""

    def __init__(
        self, first: Sequence[Wanted], later: Iterable[Variant], tell: Callable[[str, bool], None]
    ) -> None:
        self.tell = tell
        self.finished = threading.Event()
        here = str(Path(__file__).parents[2])
        code = (
            f"import sys; sys.path.insert(0, {here!r}); import derod; sys.path.pop(0); "
            "from derod.cli.helper import main; main()"
        )
        self.process = subprocess.Popen(
            [sys.executable, "-P", "-c", code],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            start_new_session=True,  # Ctrl-C is for the push, which ends its helper
        )
        from derod.cli.helper import orders

        assert self.process.stdin is not None
        with contextlib.suppress(BrokenPipeError):  # it has failed: its words are read below
            self.process.stdin.write(orders(first, later))
            self.process.stdin.flush()  # and left open: the helper ends when it is closed
        self.reader = threading.Thread(target=self._read, daemon=True)
        self.reader.start()

    def _read(self) -> None:
        assert self.process.stdout is not None
        for line in self.process.stdout:
            word, _, name = line.decode("utf-8", "replace").strip().partition(" ")
            if word in ("begin", "done"):
                self.tell(name, word == "begin")
            elif word == "first":
                self.finished.set()
        self.finished.set()

    def end(self) -> None:
        """End the process, and say so if it had failed by itself."""
        failed = self.process.poll() not in (None, 0)
        if self.process.poll() is None:
            self.process.terminate()
        try:
            _, complaint = self.process.communicate(timeout=GOODBYE)
        except subprocess.TimeoutExpired:
            self.process.kill()
            _, complaint = self.process.communicate()
        except ValueError:  # a pipe was closed when the other end broke
            complaint = b""
        if failed:
            last = complaint.decode("utf-8", "replace").strip().rpartition("\n")[2]
            say(f"derod: the process that helped to compile failed ({last}); one did it alone")


def cores() -> int:
    """The cores that this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


@contextlib.contextmanager
def kernels_ready(scene: Scene, *, quiet: bool = False) -> Iterator[None]:
    """Have the kernels of the scene's first increments compiled; what is inside finds them in the cache."""
    from derod.pushing.exercise import variant_of

    variant = variant_of(scene)
    words = Words(0)
    tell = (lambda name, begins: None) if quiet else words
    from derod.algebra import compiling

    with contextlib.ExitStack() as stack:
        compiling.listen(tell)
        stack.callback(compiling.forget, tell)
        if not is_ready(variant):
            missing = missing_first(variant)
            if missing:
                began = time.monotonic()
                words.total = len(missing)
                helper = start_helper(missing, [variant], tell)
                if helper is not None:
                    stack.callback(helper.end)
                compile_all(missing)
                words.clear()
                if not quiet:
                    took = time.monotonic() - began
                    say(f"compiled {len(missing)} kernels in {took:.0f} s, kept for next time")
            note_ready(variant)
        words.total = 0
        words.done.clear()
        yield


def missing_first(variant: Variant) -> list[Wanted]:
    """The kernels of a variant's first increments that have to be compiled."""
    from derod.algebra.survey import survey
    from derod.pushing.exercise import first_increments

    return [one for one in survey(lambda: first_increments(variant)) if not one.is_kept()]


def start_helper(
    first: Sequence[Wanted], later: Iterable[Variant], tell: Callable[[str, bool], None]
) -> Helper | None:
    """Start a helper, where there is a core for it, work to share, and a cache to share it by."""
    from derod.algebra.claims import claim_path

    if cores() < 2 or len(first) < 2 or claim_path(first[0].kernel) is None:
        return None
    try:
        return Helper(first, later, tell)
    except OSError as error:  # no more processes: one will do
        say(f"derod: no process to help with compiling ({error})")
        return None


def compile_all(wanted: Iterable[Wanted]) -> None:
    """Compile or load kernels, those first that no other process is at."""
    from derod.algebra.claims import claim_path, is_claimed_elsewhere

    left = list(wanted)
    while left:
        paths = [claim_path(one.kernel) for one in left]
        free = [path is None or not is_claimed_elsewhere(path) for path in paths]
        left.pop(free.index(True) if any(free) else 0).compile()


def is_ready(variant: Variant) -> bool:
    """Whether the first kernels of a variant were all there before, or came with the package."""
    import derod.algebra  # chooses the cache folder
    from derod.algebra import shipped

    assert derod.algebra
    return variant.name in shipped.variants() or variant.name in _noted()


def note_ready(variant: Variant) -> None:
    """Note that the first kernels of a variant are all there."""
    folder = own_folder()
    if folder is None:
        return
    beside = folder / f"{READY}.{os.getpid()}"
    with contextlib.suppress(OSError):  # only a survey saved
        beside.write_text(json.dumps(sorted({*_noted(), variant.name})))
        beside.replace(folder / READY)


def _noted() -> list[str]:
    folder = own_folder()
    if folder is None:
        return []
    try:
        noted = json.loads((folder / READY).read_text())
    except (OSError, ValueError):  # none yet, or damaged: a survey will tell
        return []
    return [name for name in noted if isinstance(name, str)] if isinstance(noted, list) else []


def own_folder() -> Path | None:
    """The cache folder, if derod chose it and not the user."""
    from derod.algebra.cache import OURS, VARIABLE

    chosen = os.environ.get(VARIABLE)
    return Path(chosen) if chosen and chosen == os.environ.get(OURS) else None
