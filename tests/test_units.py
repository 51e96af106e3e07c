"""One way of writing an end-shortening, on every line."""

from __future__ import annotations

import math

import pytest

from derod.push.frames import Ending, Event, Outcome
from derod.record.ending import ending_words, event_words, with_units
from derod.scene.axis import END_SHORTENING, axis_of, both
from tests.scenes import coil


def test_both_units() -> None:
    assert both(0.6) == "0.6 D (0.190986 pi)"
    assert both(0.6 * math.pi) == "1.88496 D (0.6 pi)"
    assert both(0.6 * math.pi, 4) == "1.885 D (0.6 pi)"
    assert axis_of(coil()) is END_SHORTENING
    assert END_SHORTENING._replace(unit="K0/D^2", in_pi=False).both(3.25) == "3.25 K0/D^2"


@pytest.mark.parametrize(
    ("message", "told"),
    [
        ("reached end-shortening 1.88496", "reached end-shortening 1.88496 D (0.6 pi)"),
        ("no way on beyond 1.88496 with steps down to 1e-3: x",
         "no way on beyond 1.88496 D (0.6 pi) with steps down to 1e-3: x"),
        ("the outer rod ran out at 1.88496", "the outer rod ran out at 1.88496 D (0.6 pi)"),
        ("already 1.88496 D (0.6 pi)", "already 1.88496 D (0.6 pi)"),
        ("11.88496, 1.884961, 1.88496e3", "11.88496, 1.884961, 1.88496e3"),
        ("nothing to say", "nothing to say"),
    ],
)  # fmt: skip
def test_bare_numbers_of_messages_get_their_units(message: str, told: str) -> None:
    assert with_units(message, 0.6 * math.pi, END_SHORTENING) == told


def test_endings_and_events_in_words() -> None:
    ending = Ending(Outcome.ROD_RAN_OUT, "the outer rod ran out at 2", 2.0)
    assert ending_words(ending, END_SHORTENING) == (
        "rod ran out: the outer rod ran out at 2 D (0.63662 pi)"
    )
    nowhere = Ending(Outcome.INTERRUPTED, "interrupted before the first increment", math.nan)
    assert ending_words(nowhere, END_SHORTENING).endswith("before the first increment")
    assert ending_words(None, END_SHORTENING).startswith("not ended")
    event = Event(3, "turn", 2.0, math.nan, math.nan, "")
    assert event_words(event, END_SHORTENING) == "turn at 2 D (0.63662 pi)"
