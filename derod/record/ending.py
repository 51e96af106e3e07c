"""How a push ended, in words, with its place in all the units it is written in."""

from __future__ import annotations

import math
import re

from derod.push.frames import Ending, Event
from derod.scene.axis import Axis


def ending_words(ending: Ending | None, axis: Axis) -> str:
    """``completed: reached end-shortening 1.88496 D (0.6 pi)``, and so on for every outcome."""
    if ending is None:
        return "not ended: it is still running, or was killed (derod push --resume goes on)"
    message = with_units(ending.message, ending.end_shortening, axis)
    return f"{ending.outcome.replace('_', ' ')}: {message}"


def event_words(event: Event, axis: Axis) -> str:
    """``snap at 1.2 D (0.381972 pi): ...``."""
    message = with_units(event.message, event.end_shortening, axis)
    return f"{event.kind} at {axis.both(event.end_shortening)}" + (
        f": {message}" if message else ""
    )


def with_units(message: str, value: float, axis: Axis) -> str:
    """``message``, in which the driver has written the bare number ``value``, with its units there."""
    if math.isnan(value):
        return message
    bare = rf"(?<![\w.+-]){re.escape(f'{value:.6g}')}(?![\w.]| {axis.unit}\b)"
    return re.sub(bare, axis.both(value), message)
