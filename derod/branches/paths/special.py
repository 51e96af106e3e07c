"""Special points of a path: folds, pitchforks, and states met on the way to another path."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.optimize import brentq

from derod.branches.half_rod import closure as col
from derod.branches.half_rod.linear import Reduced
from derod.branches.half_rod.mirror import FULL, Mirror
from derod.branches.half_rod.outcome import NotConverged
from derod.branches.half_rod.state import Increment
from derod.branches.paths.arc import Point, Tracer, frozen
from derod.branches.paths.newton import Settled, settle
from derod.branches.paths.straight import null_increment

ARC_TOLERANCE = 1e-13
FUNCTION_TOLERANCE = 1e-6
"""A located point must bring its test function below this share of the bracket's larger value."""
BISECTIONS = 8


class SpuriousPoint(ArithmeticError):  # noqa: N818 - found by its function's value, reported by the tracer
    """A test function changed sign without a zero (a pole or a jump to another path)."""


@dataclass(frozen=True)
class SpecialPoint:
    """A fold, a pitchfork or the buckling of the straight rod on a branch.

    kind: "fold", "pitchfork" or "buckling"; ``function`` is what is left of its test function,
    relative to the bracket; ``mode``: null vector out of the plane, for pitchforks.
    """

    kind: str
    point: Point
    function: float
    mode: Increment | None = None


def fold_function(point: Point) -> float:
    """d delta / d arclength."""
    return point.fold_function


def odd_determinant(odd: Mirror) -> Callable[[Point], float]:
    """The determinant of a planar path's out-of-plane block, as a function of its points."""

    def function(point: Point) -> float:
        return Reduced(point.settled.reduced.elements, odd).determinant()

    return function


def locate(
    tracer: Tracer, left: Point, right: Point, function: Callable[[Point], float], kind: str
) -> SpecialPoint:
    """The zero of a test function between two successive points, by Brent's method in arclength.

    All evaluations start from ``left``, on its mesh; where the far end cannot be reached from
    there the bracket is cut in two. Raises SpuriousPoint where the sign change has no zero.
    """
    for _ in range(BISECTIONS):
        try:
            tracer.advance(left, right.arc - left.arc, remesh=False)
        except NotConverged:
            middle = tracer.advance(left, 0.5 * (right.arc - left.arc))
            if function(left) * function(middle) > 0.0:
                left = middle
            else:
                right = middle
        else:
            break
    found: dict[float, Point] = {0.0: left}

    def value(length: float) -> float:
        if length not in found:
            found[length] = tracer.advance(left, length, remesh=False)
        return function(found[length])

    span = right.arc - left.arc
    at_left, at_right = value(0.0), value(span)
    if at_left * at_right > 0.0:
        raise SpuriousPoint(f"{kind}: the sign change is the mesh's, not the path's")
    length = brentq(value, 0.0, span, xtol=ARC_TOLERANCE, rtol=1e-14)
    rest = abs(value(length)) / max(abs(at_left), abs(at_right))
    if rest > FUNCTION_TOLERANCE:
        raise SpuriousPoint(f"{kind}: sign change without a zero (left over {rest:.1e})")
    return SpecialPoint(kind, found[length], rest)


def with_mode(special: SpecialPoint, odd: Mirror) -> SpecialPoint:
    """A pitchfork with its out-of-plane null vector."""
    mode = null_increment(Reduced(special.point.settled.reduced.elements, odd))
    return SpecialPoint(special.kind, special.point, special.function, mode)


def branch_off(
    special: SpecialPoint, control_tolerance: float, side: float = 1.0, amplitude: float = 0.02
) -> tuple[Settled, np.ndarray]:
    """A state of the space path that leaves a planar one at a pitchfork, and its outward
    direction (37,).

    The largest kept component of the null vector is held at ``side * amplitude``; ``side`` = -1
    gives the mirror image.
    """
    mode = special.mode
    if mode is None:
        raise ValueError("only pitchforks have a mode to branch off along")
    state = special.point.state
    kept = np.concatenate([mode.nodes[[0, state.inner, -1]].ravel(), mode.scalars])
    held = int(np.abs(kept).argmax())
    closing = np.stack([frozen(col.FGAMMA), frozen(held)])
    values = np.array([state.scalars[5], side * amplitude])
    start = state.moved(mode, side * amplitude)
    return settle(start, FULL, closing, values, control_tolerance, max_iterations=12), side * kept
