"""The quantity that drives a push: what its values are called, counted in, and how they are written.

Progress, messages, tables and pictures ask here, and nowhere else, what is on the axis.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    from derod.scene.tables import Scene


class Axis(NamedTuple):
    """A driving quantity: its column of a run's table, its names, its unit."""

    column: str
    symbol: str
    name: str
    unit: str
    in_pi: bool
    """Whether values are also written as multiples of pi."""

    def both(self, value: float, digits: int = 6) -> str:
        """A value in all the units it is written in: ``1.88496 D (0.6 pi)``."""
        text = f"{value:.{digits}g} {self.unit}"
        return f"{text} ({value / math.pi:.{digits}g} pi)" if self.in_pi else text


END_SHORTENING = Axis("end_shortening", "delta", "end-shortening", "D", in_pi=True)


def axis_of(scene: Scene) -> Axis:
    """What drives the push of a scene."""
    return END_SHORTENING


def both(end_shortening: float, digits: int = 6) -> str:
    """An end-shortening in both of its units: ``1.88496 D (0.6 pi)``."""
    return END_SHORTENING.both(end_shortening, digits)
