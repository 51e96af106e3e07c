"""The quantity that drives a push: what its values are called, counted in, and how they are written.

Progress, messages, tables and pictures ask here, and nowhere else, what is on the axis.
"""

from __future__ import annotations

import math
import re
from functools import partial
from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    from derod.scene.tables import Scene

NUMBER = r"[-+]?[0-9]+(?:\.[0-9]*)?(?:e[-+]?[0-9]+)?"


class Axis(NamedTuple):
    """A driving quantity: its column of a run's table, its names, its unit."""

    column: str
    symbol: str
    name: str
    unit: str
    in_pi: bool = False
    """Whether values are also written as multiples of pi."""

    def both(self, value: float, digits: int = 6) -> str:
        """A value in all the units it is written in: ``1.88496 D (0.6 pi)``."""
        text = f"{value:.{digits}g} {self.unit}"
        return f"{text} ({value / math.pi:.{digits}g} pi)" if self.in_pi else text


END_SHORTENING = Axis("end_shortening", "delta", "end-shortening", "D", in_pi=True)


class Axes(dict[str, Axis]):
    """Axes by the control's name; a control that names no unit of its own is a plain number."""

    def __missing__(self, control: str) -> Axis:
        from derod.scene.controls import HELD

        return Axis(control, control, HELD[control].words, "")


AXES = Axes(
    (axis.column, axis)
    for axis in (
        END_SHORTENING,
        Axis("end_tension", "t", "end tension", "K0/D^2"),
        Axis("end_rotation", "R", "end rotation", "rad", in_pi=True),
        Axis("capillary_force", "f_gamma", "capillary force", "K0/D^2"),
        Axis("wall_strength", "v0", "wall strength", "K0/D^2"),
        Axis("weight", "W", "weight", "K0/D^2"),
    )
)
"""By the control's name (``derod.scene.controls``)."""


def axis_of(scene: Scene, segment: int = 0) -> Axis:
    """What drives a leg of the push of a scene: the first, unless ``segment`` tells another."""
    from derod.scene.program import legs

    found = legs(scene)
    return AXES[found[min(segment, len(found) - 1)].control] if found else AXES[scene.push.control]


def axes_of(scene: Scene) -> tuple[Axis, ...]:
    """All that drive the push of a scene, leg after leg, each once."""
    from derod.scene.program import legs

    return tuple(dict.fromkeys(AXES[leg.control] for leg in legs(scene))) or (axis_of(scene),)


def both(end_shortening: float, digits: int = 6) -> str:
    """An end-shortening in both of its units: ``1.88496 D (0.6 pi)``."""
    return END_SHORTENING.both(end_shortening, digits)


def with_units(message: str, end_shortening: float) -> str:
    """``message``, in which a push has written bare numbers, with their units.

    A number that is the end-shortening gets its own; one after the words of another control, the control's.
    """
    for axis in AXES.values():
        if axis is not END_SHORTENING:
            bare = rf"\b{axis.name} ({NUMBER})(?![\w.]| {re.escape(axis.unit)})"
            message = re.sub(bare, partial(_with_unit, axis), message)
    if math.isnan(end_shortening):
        return message
    bare = rf"(?<![\w.+-]){re.escape(f'{end_shortening:.6g}')}(?![\w.]| (?:D|rad|K0)\b)"
    return re.sub(bare, both(end_shortening), message)


def _with_unit(axis: Axis, found: re.Match[str]) -> str:
    """Six digits were written; a multiple of pi made of them has five."""
    value = float(found[1])
    text = f"{axis.name} {value:.6g} {axis.unit}"
    return f"{text} ({value / math.pi:.5g} pi)" if axis.in_pi else text
