"""The observer that shows how far a push is."""

from __future__ import annotations

import itertools
import math
import sys
from collections.abc import Callable
from typing import Any, TextIO

from derod.pushing.frames import Ending, Event, Frame
from derod.scene import Scene

MEMORY = 5.0  # s, over which the pace is averaged: seconds of easy increments are soon forgotten
LINE_EVERY = 10.0  # s
LINE_AT = 0.1  # of the way


def way_covered(scene: Scene, segment: int, end_shortening: float) -> float:
    """How much end-shortening, up and down, lies between the start and this point of a leg, in D."""
    points = (scene.push.start, *scene.push.stop)
    legs = [abs(after - before) for before, after in itertools.pairwise(points)]
    return sum(legs[:segment]) + abs(end_shortening - points[segment])


class Pace:
    """Estimates the time left from the end-shortening covered in the last seconds."""

    def __init__(self) -> None:
        self._at: tuple[float, float] | None = None
        self._way = 0.0
        self._time = 0.0

    def add(self, way: float, now: float) -> None:
        """Take in that ``way`` (D) is covered at the time ``now`` (s)."""
        if self._at is not None:
            step = max(now - self._at[1], 0.0)
            keep = math.exp(-step / MEMORY)
            self._way = keep * self._way + way - self._at[0]
            self._time = keep * self._time + step
        self._at = (way, now)

    def seconds_left(self, total: float) -> float | None:
        """Time to ``total`` (D) at the present pace, or None while there is no telling."""
        if self._at is None or self._way <= 0.0 or self._time <= 0.0:
            return None
        return max(total - self._at[0], 0.0) * self._time / self._way


def working_clock() -> float:
    """Seconds without those of compilation."""
    from derod.algebra import compiling  # imports numba: not before the first line is printed

    return compiling.clock()


class Progress:
    """Shows end-shortening, tension, unstable modes and the time left.

    A bar on a terminal, and elsewhere a line now and then.
    """

    def __init__(
        self, stream: TextIO | None = None, clock: Callable[[], float] | None = None
    ) -> None:
        self._stream = sys.stderr if stream is None else stream
        self._clock = working_clock if clock is None else clock
        self._pace = Pace()
        self._bar: Any = None

    def start(self, scene: Scene, first_increment: int) -> None:
        """Show that the push begins."""
        self._scene = scene
        legs = len(scene.push.stop)
        self._total = way_covered(scene, legs - 1, scene.push.stop[-1])
        self._began = self._clock()
        self._shown = (0.0, self._began)
        if self._stream.isatty():
            from tqdm import tqdm  # 70 ms, only for those who watch

            self._bar = tqdm(
                total=self._total / math.pi,
                file=self._stream,
                bar_format="{percentage:3.0f}%|{bar:24}| {desc}",
                desc="settling the first state",
                leave=True,
            )

    def event(self, event: Event) -> None:
        """Say what happened."""
        self._say(
            f"{event.kind} at {event.end_shortening / math.pi:.4f} pi"
            + (f": {event.message}" if event.message else "")
        )

    def frame(self, frame: Frame) -> None:
        """Show how far the push is."""
        row, now = frame.row, self._clock()
        way = way_covered(self._scene, int(row["segment"]), float(row["end_shortening"]))
        self._pace.add(way, now)
        text = self._state(row, now)
        if self._bar is not None:
            self._bar.n = min(way, self._total) / math.pi
            self._bar.set_description_str(text, refresh=False)
            self._bar.update(0)
        elif way - self._shown[0] >= LINE_AT * self._total or now - self._shown[1] >= LINE_EVERY:
            self._shown = (way, now)
            self._say(text)

    def finish(self, ending: Ending) -> None:
        """Take the bar down; the command says how it ended."""
        if self._bar is not None:
            self._bar.refresh()
            self._bar.close()
            self._bar = None

    def _state(self, row: Any, now: float) -> str:
        left = self._pace.seconds_left(self._total)
        return (
            f"{row['end_shortening'] / math.pi:.3f} of {self._scene.push.stop[-1] / math.pi:g} pi"
            f"  t = {row['end_tension']:.3f}  unstable {row['unstable_modes']}"
            f"  {clock_time(now - self._began)}"
            f", {'?' if left is None else clock_time(left)} left"
        )

    def _say(self, text: str) -> None:
        if self._bar is not None:
            self._bar.write(text, file=self._stream)
        else:
            print(text, file=self._stream, flush=True)


def clock_time(seconds: float) -> str:
    """Seconds as 7 s, 1:05 or 2:03:04."""
    whole = round(seconds)
    if whole < 60:
        return f"{whole} s"
    minutes, rest = divmod(whole, 60)
    hours, minutes = divmod(minutes, 60)
    return f"{hours}:{minutes:02}:{rest:02}" if hours else f"{minutes}:{rest:02}"
