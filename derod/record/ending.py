"""How a push ended, in words, with its place in all the units it is written in."""

from __future__ import annotations

from derod.pushing.frames import Ending, Event
from derod.scene.axis import both, with_units


def ending_words(ending: Ending | None) -> str:
    """``completed: reached end-shortening 1.88496 D (0.6 pi)``, and so on for every outcome."""
    if ending is None:
        return "not ended: it is still running, or was killed (derod push --resume goes on)"
    message = with_units(ending.message, ending.end_shortening)
    return f"{ending.outcome.replace('_', ' ')}: {message}"


def event_words(event: Event) -> str:
    """``snap at 1.2 D (0.381972 pi): ...``."""
    message = with_units(event.message, event.end_shortening)
    return f"{event.kind} at {both(event.end_shortening)}" + (f": {message}" if message else "")
