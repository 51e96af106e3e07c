"""One way of writing an end-shortening, on every line."""

from __future__ import annotations

import math

import pytest

from derod.pushing.frames import Ending, Event, Outcome
from derod.record.ending import ending_words, event_words
from derod.scene.axis import AXES, END_SHORTENING, axes_of, axis_of, both, with_units
from derod.scene.controls import HELD
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
        ("reached end rotation 3.14159", "reached end rotation 3.14159 rad (1 pi)"),
        ("reached end tension -2.5e-3", "reached end tension -0.0025 K0/D^2"),
        ("no way on beyond weight 2 with", "no way on beyond weight 2 K0/D^2 with"),
        ("weight 2 K0/D^2", "weight 2 K0/D^2"),
    ],
)  # fmt: skip
def test_bare_numbers_of_messages_get_their_units(message: str, told: str) -> None:
    assert with_units(message, 0.6 * math.pi) == told


def test_endings_and_events_in_words() -> None:
    ending = Ending(Outcome.ROD_RAN_OUT, "the outer rod ran out at 2", 2.0)
    assert ending_words(ending) == ("rod ran out: the outer rod ran out at 2 D (0.63662 pi)")
    nowhere = Ending(Outcome.INTERRUPTED, "interrupted before the first increment", math.nan)
    assert ending_words(nowhere).endswith("before the first increment")
    assert ending_words(None).startswith("not ended")
    event = Event(3, "turn", 2.0, math.nan, math.nan, "")
    assert event_words(event) == "turn at 2 D (0.63662 pi)"


def test_every_control_has_an_axis() -> None:
    from derod.pushing.controls import CONTROLS

    assert set(AXES) == set(HELD) == set(CONTROLS)
    for name, control in CONTROLS.items():
        axis = AXES[name]
        assert axis.name == HELD[name].words
        assert axis.unit == control.unit.replace("D-2", "D^2").replace(" ", "/", 1)


def test_axes_of_a_push_in_steps() -> None:
    scene = coil().replace(
        {
            "steps": [
                {"control": "end_rotation", "stop": "pi"},
                {"control": "end_tension", "stop": 9},
            ]
        }
    )
    assert [axis.column for axis in axes_of(scene)] == [
        "end_shortening", "end_rotation", "end_tension"]  # fmt: skip
    assert axis_of(scene).column == "end_shortening" and axis_of(scene, 1).unit == "rad"
