"""A path from end to end: when it is left, its last point, its special points."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Generic, TypeVar

from derod.branches.half_rod import closure as col
from derod.branches.half_rod.mirror import Mirror
from derod.branches.half_rod.outcome import NotConverged
from derod.branches.paths.arc import Point, Tracer, frozen
from derod.branches.paths.newton import Settled
from derod.branches.paths.special import (
    SpecialPoint,
    SpuriousPoint,
    fold_function,
    locate,
    odd_determinant,
    with_mode,
)

OUTER_END = 1e-3
"""The outer rod has run out when its half is this short (D)."""
TENSION_LIMIT = 4.0
"""Paths are left where the tension passes this multiple of f_gamma."""
MESH_LIMIT = 900
"""More elements than this mean that the wall layer is no longer resolved."""

_T = TypeVar("_T")


@dataclass(frozen=True)
class TwoWays(Generic[_T]):
    """What ``two_ways`` finds: points, special points with the index of the point before, both ends."""

    points: list[Point]
    specials: list[tuple[int, SpecialPoint]]
    begins: str
    ends: _T | str


def end_reason(delta_limit: float) -> Callable[[Point], str | None]:
    """The stop test of every path."""

    def reason(point: Point) -> str | None:
        state = point.state
        force = float(state.scalars[5])
        if 0.5 * state.parameters.length - state.sigma < OUTER_END:
            return "the outer rod ran out"
        if abs(state.end_tension) > TENSION_LIMIT * force:
            return f"tension beyond {TENSION_LIMIT:g} f_gamma"
        if state.end_shortening > delta_limit:
            return "limit of end-shortening"
        if state.end_shortening < 0.0:
            return "end-shortening back at zero"
        if state.eta.size > MESH_LIMIT:
            return "wall layer unresolved"
        return None

    return reason


def collect(
    tracer: Tracer, start: Point, stop: Callable[[Point], _T | None]
) -> tuple[list[Point], _T | str]:
    """All points from ``start`` on, and why they end."""
    points: list[Point] = []
    steps = tracer.march(start, stop)
    while True:
        try:
            points.append(next(steps))
        except StopIteration as end:
            return points, end.value


def finish_at_end(tracer: Tracer, points: list[Point]) -> None:
    """Put the last point of a path whose outer rod ran out at OUTER_END.

    Where that state cannot be reached, the path ends with the last point inside.
    """

    def left_over(point: Point) -> float:
        return 0.5 * point.state.parameters.length - point.state.sigma - OUTER_END

    if len(points) > 1 and left_over(points[-1]) < 0.0 < left_over(points[-2]):
        try:
            points[-1] = locate(tracer, points[-2], points[-1], left_over, "end").point
        except (NotConverged, SpuriousPoint):
            points.pop()


def special_points(
    tracer: Tracer, points: list[Point], odd: Mirror | None, remarks: list[str]
) -> list[tuple[int, SpecialPoint]]:
    """Folds and, on planar paths, pitchforks; each with the index of the point it follows.

    A sign change without a zero (two zeros close together, shaken apart by a change of mesh) gives
    no special point and a line in ``remarks``.
    """
    tests: list[tuple[str, Callable[[Point], float]]] = [("fold", fold_function)]
    if odd is not None:
        tests.append(("pitchfork", odd_determinant(odd)))
    out = []
    for kind, function in tests:
        values = [function(p) for p in points]
        for i in range(len(points) - 1):
            if values[i] * values[i + 1] >= 0.0:
                continue
            try:
                special = locate(tracer, points[i], points[i + 1], function, kind)
            except (SpuriousPoint, NotConverged) as error:
                delta = points[i].state.end_shortening
                remarks.append(f"near delta = {delta:.5f}: {error}")
                continue
            if kind == "pitchfork" and odd is not None:
                special = with_mode(special, odd)
            out.append((i, special))
    out.sort(key=lambda item: item[1].point.arc)
    return out


def reversed_path(points: list[Point]) -> list[Point]:
    """A path in the other sense: arclengths and tangents with their signs changed."""
    return [Point(p.settled, -p.tangent, -p.arc) for p in reversed(points)]


def two_ways(
    tracer: Tracer,
    settled: Settled,
    odd: Mirror | None,
    remarks: list[str],
    ahead: Callable[[Point], _T | None],
    behind: Callable[[Point], str | None],
) -> TwoWays[_T]:
    """The path through a settled state, its points in the sense of growing delta there.

    ``ahead`` and ``behind`` are the stop tests that way and the other. Special points are looked for on
    each leg by itself.
    """
    forward = frozen(col.DELTA)
    up, end = collect(tracer, tracer.begin(settled, forward), ahead)
    down, begin = collect(tracer, tracer.begin(settled, -forward), behind)
    finish_at_end(tracer, up)
    finish_at_end(tracer, down)
    back = [
        (i, replace(s, point=Point(s.point.settled, -s.point.tangent, -s.point.arc)))
        for i, s in reversed(special_points(tracer, down, odd, remarks))
    ]
    on = [(i + len(down) - 1, s) for i, s in special_points(tracer, up, odd, remarks)]
    return TwoWays(reversed_path(down)[:-1] + up, [*back, *on], str(begin), end)
