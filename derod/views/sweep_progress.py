"""How far a sweep is: points, failures, and the time left."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from typing import Any, TextIO

from derod.sweeps.running import Tally
from derod.views.progress import LINE_AT, LINE_EVERY, clock_time


class SweepProgress:
    """A bar on a terminal (with ``everywhere`` anywhere), and elsewhere a line now and then; a context."""

    def __init__(
        self,
        stream: TextIO | None = None,
        clock: Callable[[], float] = time.monotonic,
        *,
        everywhere: bool = False,
    ) -> None:
        self._stream = sys.stderr if stream is None else stream
        self._clock = clock
        self._everywhere = everywhere
        self._bar: Any = None
        self._began: float | None = None
        self._shown = (0, 0.0)

    def __call__(self, tally: Tally) -> None:
        """Show how far it is."""
        now = self._clock()
        done = tally.before + tally.done
        if self._began is None:
            self._began, self._shown = now, (done, now)
            self._open(tally, done)
        if self._bar is not None:
            self._bar.n = done
            self._bar.set_description_str(self._state(tally, now), refresh=False)
            self._bar.update(0)
        elif (
            done - self._shown[0] >= LINE_AT * tally.total or now - self._shown[1] >= LINE_EVERY
        ) and tally.done:
            self._shown = (done, now)
            self.say(self._state(tally, now))

    def say(self, line: str) -> None:
        """A remark beside the bar."""
        if self._bar is not None:
            self._bar.write(line, file=self._stream)
        else:
            print(line, file=self._stream, flush=True)

    def _open(self, tally: Tally, done: int) -> None:
        if not (self._everywhere or self._stream.isatty()):
            return
        if self._everywhere:
            from tqdm.auto import tqdm
        else:
            from tqdm import tqdm
        self._bar = tqdm(
            total=tally.total,
            initial=done,
            file=self._stream,
            bar_format="{percentage:3.0f}%|{bar:16}| {desc}",
            leave=True,
        )

    def _state(self, tally: Tally, now: float) -> str:
        began = now if self._began is None else self._began
        left = tally.total - tally.before - tally.done
        time_left = "?" if not tally.done else clock_time((now - began) / tally.done * left)
        failed = f", {tally.failed} not completed" if tally.failed else ""
        return (
            f"{tally.before + tally.done} of {tally.total} points{failed}"
            f"  {clock_time(now - began)}, {time_left} left"
        )

    def __enter__(self) -> SweepProgress:
        return self

    def __exit__(self, *_: object) -> None:
        if self._bar is not None:
            self._bar.refresh()
            self._bar.close()
            self._bar = None
