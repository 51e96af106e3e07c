"""The observer that shows how far a push is."""

from __future__ import annotations

import math
import sys
from collections.abc import Callable
from typing import Any, TextIO

from derod.pushing.frames import Ending, Event, Frame
from derod.scene import Scene
from derod.scene.axis import AXES, END_SHORTENING
from derod.scene.program import legs, ways

MEMORY = 5.0  # s, over which the pace is averaged: seconds of easy increments are soon forgotten
LINE_EVERY = 10.0  # s
LINE_AT = 0.1  # of the way


class Way:
    """The way of a push, leg after leg, up and down, in its largest increments."""

    def __init__(self, scene: Scene) -> None:
        self.axes = [AXES[leg.control] for leg in legs(scene)]
        self.stops = [leg.stop for leg in legs(scene)]
        self._steps = [leg.max_step for leg in legs(scene)]
        self._begins = [begin for begin, _ in ways(scene)]

    @property
    def total(self) -> float:
        """All of it; a leg whose begin is not known yet counts as one increment."""
        return sum(self._length(k) for k in range(len(self.stops)))

    def covered(self, segment: int, value: float) -> float:
        """What lies before a value of the control of a leg."""
        if math.isnan(self._begins[segment]):  # the control was free before: it begins here
            self._begins[segment] = value
        here = abs(value - self._begins[segment]) / self._steps[segment]
        return sum(self._length(k) for k in range(segment)) + here

    def _length(self, k: int) -> float:
        length = abs(self.stops[k] - self._begins[k]) / self._steps[k]
        return 1.0 if math.isnan(length) else length


class Pace:
    """Estimates the time left from the end-shortening covered in the last seconds."""

    def __init__(self) -> None:
        self._at: tuple[float, float] | None = None
        self._way = 0.0
        self._time = 0.0

    def add(self, way: float, now: float) -> None:
        """Take in that ``way`` is covered at the time ``now`` (s)."""
        if self._at is not None:
            step = max(now - self._at[1], 0.0)
            keep = math.exp(-step / MEMORY)
            self._way = keep * self._way + way - self._at[0]
            self._time = keep * self._time + step
        self._at = (way, now)

    def seconds_left(self, total: float) -> float | None:
        """Time to ``total`` at the present pace, or None while there is no telling."""
        if self._at is None or self._way <= 0.0 or self._time <= 0.0:
            return None
        return max(total - self._at[0], 0.0) * self._time / self._way


def working_clock() -> float:
    """Seconds without those of compilation."""
    from derod.algebra import compiling  # imports numba: not before the first line is printed

    return compiling.clock()


class Progress:
    """Shows end-shortening, tension, unstable modes and the time left.

    A bar on a terminal, and elsewhere a line now and then; with ``everywhere`` a bar in any case, and in a
    notebook that of the notebook.
    """

    def __init__(
        self,
        stream: TextIO | None = None,
        clock: Callable[[], float] | None = None,
        *,
        everywhere: bool = False,
    ) -> None:
        self._stream = sys.stderr if stream is None else stream
        self._everywhere = everywhere
        self._clock = working_clock if clock is None else clock
        self._pace = Pace()
        self._bar: Any = None

    def start(self, scene: Scene, first_increment: int) -> None:
        """Show that the push begins."""
        self._scene = scene
        self._way = Way(scene)
        self._began = self._clock()
        self._shown = (0.0, self._began)
        if self._everywhere or self._stream.isatty():
            if self._everywhere:
                from tqdm.auto import tqdm
            else:
                from tqdm import tqdm  # 70 ms, only for those who watch

            self._bar = tqdm(
                total=self._way.total,
                file=self._stream,
                bar_format="{percentage:3.0f}%|{bar:16}| {desc}",
                desc="settling the first state",
                leave=True,
            )

    def event(self, event: Event) -> None:
        """Say what happened."""
        from derod.record.ending import event_words

        self._say(event_words(event))

    def frame(self, frame: Frame) -> None:
        """Show how far the push is."""
        row, now = frame.row, self._clock()
        segment = int(row["segment"])
        way = self._way.covered(segment, float(row[self._way.axes[segment].column]))
        self._pace.add(way, now)
        text = self._state(row, now)
        if self._bar is not None:
            self._bar.n = min(way, self._way.total)
            self._bar.set_description_str(text, refresh=False)
            self._bar.update(0)
        elif (
            way - self._shown[0] >= LINE_AT * self._way.total or now - self._shown[1] >= LINE_EVERY
        ):
            self._shown = (way, now)
            self._say(text)

    def finish(self, ending: Ending) -> None:
        """Take the bar down; the command says how it ended."""
        if self._bar is not None:
            self._bar.refresh()
            self._bar.close()
            self._bar = None

    def _state(self, row: Any, now: float) -> str:
        segment = int(row["segment"])
        left, axis = self._pace.seconds_left(self._way.total), self._way.axes[segment]
        goal = self._way.stops[segment]
        name = "" if axis is END_SHORTENING else f"{axis.symbol} = "
        return (
            f"{name}{axis.both(float(row[axis.column]), 4)} of {axis.both(goal, 4)}"
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
