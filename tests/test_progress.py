"""What a push shows of itself, on a terminal and elsewhere."""

from __future__ import annotations

import io
import math

import pytest

from derod.pushing.frames import Ending, Outcome
from derod.views.progress import Pace, Progress, Way, clock_time
from tests.synthetic import drive, make_event, make_frame, small_scene


class Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


class Clock:
    """A clock that moves by ``step`` seconds each time it is read."""

    def __init__(self, step: float) -> None:
        self.now, self.step = 100.0, step

    def __call__(self) -> float:
        self.now += self.step
        return self.now


def shown(stream: io.StringIO, step: float) -> str:
    drive(small_scene(), [Progress(stream, Clock(step))])
    return stream.getvalue()


def test_elsewhere_a_line_now_and_then() -> None:
    text = shown(io.StringIO(), 0.01)
    states = [line for line in text.splitlines() if "unstable" in line]
    assert 8 <= len(states) <= 10, "one a tenth of the way, not one an increment"
    assert all(" of 1.257 D (0.4 pi)  t = " in line for line in states)
    assert states[-1].startswith(("1.257 D (0.4 pi) of", "1.225 D (0.39 pi) of", "1.162 D (0.37"))
    assert "\r" not in text and "\x1b" not in text and "%|" not in text


def test_elsewhere_a_slow_push_says_so_every_ten_seconds() -> None:
    text = shown(io.StringIO(), 11.0)
    assert len([line for line in text.splitlines() if " left" in line]) == 40


def test_events_are_told() -> None:
    for stream in (io.StringIO(), Terminal()):
        text = shown(stream, 0.01)
        assert text.count("instability at ") == 8
        assert "instability at 0.05 D (0.0159155 pi): before increment 4: é" in text


def test_a_bar_on_a_terminal() -> None:
    text = shown(Terminal(), 0.5)
    assert "settling the first state" in text
    last = text.split("\r")[-1]
    assert "100%|" in last and "1.257 D (0.4 pi) of 1.257 D (0.4 pi)" in last and "0 s left" in last
    assert text.endswith("\n")


def test_a_push_that_ends_early_takes_its_bar_down() -> None:
    stream = Terminal()
    progress = Progress(stream, Clock(1.0))
    progress.start(small_scene(), 0)
    progress.frame(make_frame(0, 24, 0.1 * math.pi))
    progress.finish(Ending(Outcome.INTERRUPTED, "", 0.1 * math.pi))
    length = len(stream.getvalue())
    progress.finish(Ending(Outcome.INTERRUPTED, "", 0.1 * math.pi))
    assert stream.getvalue().endswith("\n") and len(stream.getvalue()) == length
    progress.event(make_event(0))  # afterwards a plain line, no crash
    assert stream.getvalue().endswith("é\n")


def test_the_way_is_counted_up_and_down() -> None:
    scene = small_scene(push__stop=[1.0, 0.5, 0.75], push__start=0.25, push__at=[])
    way, step = Way(scene), scene.push.max_step
    assert way.covered(0, 0.5) == pytest.approx(0.25 / step)
    assert way.covered(1, 0.75) == pytest.approx(1.0 / step)
    assert way.covered(2, 0.75) == way.total == pytest.approx(1.5 / step)


def test_the_way_of_a_push_in_steps() -> None:
    scene = small_scene(
        push__stop=[1.0],
        push__start=0.25,
        push__at=[],
        steps=[
            {"control": "end_rotation", "stop": 2.0, "max_step": 0.5},
            {"control": "end_tension", "stop": 10.0, "max_step": 1.0},
        ],
    )
    way, first = Way(scene), 0.75 / scene.push.max_step
    assert way.total == pytest.approx(first + 4 + 1), "the tension's begin is not known yet"
    assert way.covered(1, 1.0) == pytest.approx(first + 2)
    assert way.covered(2, 12.0) == pytest.approx(first + 4)
    assert way.covered(2, 11.0) == pytest.approx(first + 5)
    assert way.total == pytest.approx(first + 4 + 2)


def test_the_pace_forgets() -> None:
    pace = Pace()
    assert pace.seconds_left(1.0) is None
    pace.add(0.0, 0.0)
    assert pace.seconds_left(1.0) is None
    for i in range(1, 11):
        pace.add(0.01 * i, 0.1 * i)  # 0.1 a second
    assert pace.seconds_left(1.1) == pytest.approx(10.0)
    for i in range(1, 101):
        pace.add(0.1 + 0.001 * i, 1.0 + i)  # a hundred times slower, for long
    assert pace.seconds_left(1.2) == pytest.approx(1000.0, rel=0.01)
    pace.add(5.0, 102.0)
    assert pace.seconds_left(1.2) == 0.0


@pytest.mark.parametrize(
    ("seconds", "text"),
    [(0.2, "0 s"), (59.4, "59 s"), (59.6, "1:00"), (65, "1:05"), (3599.9, "1:00:00"),
     (7384, "2:03:04")],
)  # fmt: skip
def test_times(seconds: float, text: str) -> None:
    assert clock_time(seconds) == text
