r"""Folds, branch points and joints between two points of a path, located.

    fold          the control turns, the count changes by one          dp/ds = 0
    branch point  the count changes and the control goes on            mu = 0, the critical eigenvalue
    joint         the control turns and the count does not change      dp/ds = 0

A joint is a pitchfork met from the side of its branches: behind it the path is its own mirror image. dp/ds
and mu are smooth in s and change their sign: a secant that keeps its bracket (Anderson and Bjorck, 1973)
finds the place s*. The control there is read off the nearest point by its own rate, quadratically off at a
fold, so that errors fall like the square of the last step.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from derod.rod.state import State
from derod.tracing.arc import Arc, Point
from derod.tracing.bordered import Vector
from derod.tracing.critical import nearest_modes

REGION = 0.1  # of the bracket
LOOKS = 14  # points that are settled for one place, at most
CLOSE = 1e-8  # of the bracket, the last secant step
ALONG = 0.9  # |cos| of the null mode to the tangent, beyond which the control turns
NARROWEST = 1e-5  # of the first step: two changes closer than that are one of higher multiplicity

FOLD, BRANCH_POINT, JOINT = "fold", "branch point", "joint"


@dataclass(slots=True, eq=False)
class Special:
    """A special point of a path."""

    kind: str
    arc: float
    value: float  # of the control, in the rod's units
    point: Point  # settled, and the nearest
    mode: Vector | None  # the null mode, where it is no tangent
    eigenvalue: float  # what is left of it at the nearest point, K/D^4
    change: int  # of the count, along the path
    error: float  # of the control, estimated from the last secant step
    base: State  # on the path at ``arc``, without the rounding that a singular matrix amplifies
    partner: str = ""
    fate: str = ""  # what came of switching there (``explore``)
    symmetric: bool = True  # a pitchfork; else transcritical


def specials(arc: Arc, a: Point, b: Point, span: float | None = None) -> list[Special]:
    """Return the special points between neighbours ``a`` and ``b`` of a path, in order.

    Only changes that leave a trace in the count or in the control's direction are seen.
    """
    turns, change = a.rate * b.rate < 0, b.count - a.count
    if not turns and change == 0:
        return []
    span = b.arc - a.arc if span is None else span
    if turns and abs(change) <= 1:
        kind = FOLD if change else JOINT
        found = locate(arc, a, b, kind, lambda point: point.rate)
        return [] if found is None else [found]
    if (not turns and abs(change) == 1) or b.arc - a.arc < NARROWEST * span:
        found = locate(arc, a, b, BRANCH_POINT, crossing_eigenvalue(arc, a, b))
        if found is None:
            return []
        if overlap(arc, found) < ALONG or b.arc - a.arc < NARROWEST * span:
            return [found]  # else two turns lie in the interval
    middle = arc.step(a, None, 0.5 * (b.arc - a.arc))
    if middle is None:
        return []
    return [*specials(arc, a, middle, span), *specials(arc, middle, b, span)]


def overlap(arc: Arc, special: Special) -> float:
    """Return the cosine of the null mode to the path's tangent."""
    return 0.0 if special.mode is None else abs(arc.inner(special.point, special.mode, 0.0))


def crossing_eigenvalue(arc: Arc, a: Point, b: Point) -> Callable[[Point], float]:
    """Return the function mu: the eigenvalue that changes its sign between two points."""
    middle, rising = 0.5 * (a.count + b.count), b.count < a.count

    def mu(point: Point) -> float:
        values, _ = nearest_modes(arc.system, point.state, 3)
        before = (point.count > middle) == rising  # on the side of a
        negative = before == rising
        side = values[values < 0] if negative else values[values >= 0]
        return float(side[np.argmin(np.abs(side))]) if side.size else (-1.0 if negative else 1.0)

    return mu


def locate(
    arc: Arc, a: Point, b: Point, kind: str, function: Callable[[Point], float]
) -> Special | None:
    """Return the special point where ``function`` vanishes between two points."""
    low, high = (a.arc, function(a)), (b.arc, function(b))
    if not low[1] * high[1] < 0:
        return None
    near = a if abs(low[1]) < abs(high[1]) else b
    nearest = (near, min(abs(low[1]), abs(high[1])))
    width, best, error = b.arc - a.arc, near.arc, b.arc - a.arc
    last_side = 0
    weights = [1.0, 1.0]
    for _ in range(LOOKS):
        fa, fb = weights[0] * low[1], weights[1] * high[1]
        before, best = best, low[0] - fa * (high[0] - low[0]) / (fb - fa)
        error = abs(best - before)
        if error <= CLOSE * width or abs(best - nearest[0].arc) <= 1e-3 * CLOSE * width:
            break
        origin = min((a, b, nearest[0]), key=lambda point: abs(point.arc - best))
        point = arc.step(origin, None, best - origin.arc, REGION * width)
        if point is None:
            break
        value = function(point)
        if abs(value) <= nearest[1]:
            nearest = (point, abs(value))
        if value == 0.0:
            best = point.arc
            break
        side = 1 if value * high[1] > 0 else -1
        if side > 0:
            shrink = max(0.1, 1 - value / high[1]) if last_side > 0 else 1.0
            high, weights = (point.arc, value), [shrink if last_side > 0 else 1.0, 1.0]
        else:
            shrink = max(0.1, 1 - value / low[1]) if last_side < 0 else 1.0
            low, weights = (point.arc, value), [1.0, shrink if last_side < 0 else 1.0]
        last_side = side
    point = nearest[0]
    offset = best - point.arc
    rate = 0.5 * point.rate if kind != BRANCH_POINT else point.rate
    values, modes = nearest_modes(arc.system, point.state, 1)
    return Special(
        kind, best, point.value + rate * offset, point, modes[0], float(values[0]), b.count - a.count,
        abs(rate) * error, between(arc, a, b, best),
    )  # fmt: skip


def between(arc: Arc, a: Point, b: Point, place: float) -> State:
    """Return the state at the arclength ``place`` between two points, by Hermite's cubic; not settled."""
    span = b.arc - a.arc
    u = (place - a.arc) / span
    near, far = (1 + 2 * u) * (1 - u) ** 2, u * u * (3 - 2 * u)
    own, other = u * (1 - u) ** 2 * span, u * u * (u - 1) * span
    state = a.state.copy()
    state.q[:] = near * a.state.q + far * b.state.q
    state.q[1:, : state.width] += own * a.tangent.rows + other * b.tangent.rows
    size = state.b.size
    state.b[:] = near * a.state.b + far * b.state.b
    state.b += own * a.tangent.border[:size] + other * b.tangent.border[:size]
    state.holonomy = near * a.state.holonomy + far * b.state.holonomy
    value = near * a.value + far * b.value + own * a.rate + other * b.rate
    arc.control.set(state, value)
    state.read_end()
    return state
