"""A branch: its name, its points with their errors, its special points, and why it ends."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import TypeVar

from derod.branches.half_rod.mesh import halved
from derod.branches.half_rod.mirror import Mirror
from derod.branches.half_rod.observables import observables
from derod.branches.half_rod.outcome import NotConverged
from derod.branches.half_rod.state import HalfRod
from derod.branches.paths.arc import Point, Tracer
from derod.branches.paths.error import refined
from derod.branches.paths.special import (
    SpecialPoint,
    SpuriousPoint,
    fold_function,
    locate,
    odd_determinant,
    with_mode,
)
from derod.branches.paths.stability import unstable_modes

OUTER_END = 1e-3
"""The outer rod has run out when its half is this short (D)."""
TENSION_LIMIT = 4.0
"""Paths are left where the tension passes this multiple of f_gamma."""
MESH_LIMIT = 900
"""More elements than this mean that the wall layer is no longer resolved."""

_T = TypeVar("_T")


@dataclass(frozen=True)
class Stored:
    """A branch's point as it is written: state, numbers, mesh-halving error, label of a special
    point."""

    state: HalfRod
    values: dict[str, float]
    error: float
    label: str = ""
    unstable_modes: int = -1


@dataclass(frozen=True)
class Bifurcation:
    """A special point of a branch: its index among the points, kind, and the branch that leaves
    there."""

    index: int
    kind: str
    partner: str
    function: float


@dataclass
class Branch:
    """A named solution branch."""

    name: str
    even: Mirror
    points: list[Stored]
    bifurcations: list[Bifurcation] = field(default_factory=list)
    begins: str = ""
    ends: str = ""
    remarks: list[str] = field(default_factory=list)  # sign changes that were no zeros


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


def stored(
    tracer: Tracer, point: Point, label: str = "", count_modes: bool = True, beside: bool = False
) -> Stored:
    """A path's point refined to the wanted accuracy, its unstable modes counted.

    ``beside``: a fold or pitchfork is the next point; a mode is soft, and is counted on elements
    cut in two.
    """
    state, error = refined(tracer, point)
    modes = -1
    if count_modes:
        modes = sum(unstable_modes(halved(state) if beside else state, critical=bool(label)))
    return Stored(state, observables(state), error, label, modes)


def merged(
    points: list[Point], specials: list[tuple[int, SpecialPoint]]
) -> list[tuple[Point, SpecialPoint | None]]:
    """Points and special points in the order of the path's arclength."""
    out: list[tuple[Point, SpecialPoint | None]] = [(p, None) for p in points]
    for _, special in specials:
        out.append((special.point, special))
    out.sort(key=lambda item: item[0].arc)
    return out


def reversed_path(points: list[Point]) -> list[Point]:
    """A path in the other sense: arclengths and tangents with their signs changed."""
    return [Point(p.settled, -p.tangent, -p.arc) for p in reversed(points)]
