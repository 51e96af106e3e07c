"""A path from its first point to its end: steps as its curvature allows, and what lies between them."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field

from derod.rod.state import State
from derod.tracing.arc import Arc, Point
from derod.tracing.special import BRANCH_POINT, FOLD, JOINT, Special, specials
from derod.tracing.symmetry import distance, node_weights

OUTER_LEAST = 0.01  # D; a rod with less outside the drop has run out
GOAL = 0.15  # rad that the tangent shall turn in a step
LONGER, SHORTER = 1.5, 0.5
EASY = 4  # Newton's iterations of a step that may be followed by a longer one
HEAD_ON = 0.5  # the least cosine of the directions where a loop closes


@dataclass(frozen=True, slots=True)
class Limits:
    """What a path is followed within."""

    low: float = -math.inf  # of the control, in the rod's units
    high: float = math.inf
    energy_hat: float = math.inf  # K/D
    points: int = 1000
    first: float = 0.02  # of the arclength's steps, D
    longest: float = 0.4
    shortest: float = 1e-5


@dataclass(slots=True)
class Path:
    """A path and what is known of it."""

    name: str
    points: list[Point]
    specials: list[Special] = field(default_factory=list)
    begins: str = ""
    ends: str = ""
    whole: bool = (
        True  # it ended for a reason of its own, or at a limit; False: no way on was found
    )

    def reversed(self) -> Path:
        """Return the path run from its end."""
        last = self.points[-1].arc
        for point in self.points:
            point.arc = last - point.arc
            point.tangent, point.rate = point.tangent.times(-1.0), -point.rate
        for special in self.specials:
            special.arc, special.change = last - special.arc, -special.change
        return Path(
            self.name, self.points[::-1], self.specials[::-1], self.ends, self.begins, self.whole
        )


Watch = Callable[[Path], None]


def follow(
    arc: Arc, first: Point, limits: Limits, name: str = "", watch: Watch | None = None
) -> Path:
    """Follow a path from its first point along that one's tangent."""
    path = Path(name, [first])
    size = limits.first
    here, before = first, None
    while True:
        if len(path.points) >= limits.points:
            path.ends, path.whole = f"{limits.points} points", False
            return path
        there = arc.step(here, before, size)
        if there is None:
            size *= SHORTER
            if size >= limits.shortest:
                continue
            path.ends, path.whole = stuck_words(arc, here), False
            if arc.system.outer_length(here.state) < 10 * OUTER_LEAST:
                path.ends, path.whole = "the outer rod has run out", True
            return path
        found = specials(arc, here, there)
        path.specials += found
        turns = [special for special in found if special.kind in (FOLD, JOINT)]
        joint = next((special for special in turns if special.kind == JOINT), None)
        for special in turns:  # the control is monotone between neighbours
            if path.points[-1].arc < special.point.arc < there.arc:
                # one eigenvalue is zero there: rounding would decide the count
                special.point.here.unstable_modes = min(here.count, there.count)
                path.points.append(special.point)
            if special is joint:
                break
        if joint is not None:
            path.ends = "joins another path, as its own mirror image"
            return path
        path.points.append(there)
        if watch is not None:
            watch(path)
        reason = end_reason(arc, path, here, limits)
        if reason:
            path.ends = reason
            return path
        factor = GOAL / max(there.turned, 1e-12)
        if there.iterations > EASY:
            factor = min(factor, 1.0 if there.iterations == EASY + 1 else 0.7)
        size = min(limits.longest, size * min(LONGER, max(SHORTER, factor)))
        before, here = here, there


def end_reason(arc: Arc, path: Path, before: Point, limits: Limits) -> str:
    """Return why a path ends at its last point, reached from ``before``, or nothing."""
    last, first = path.points[-1], path.points[0]
    if not limits.low <= last.value <= limits.high:
        return "the control's range ends"
    if last.here.energy_hat > max(limits.energy_hat, before.here.energy_hat):
        return "the limit of energy"
    if arc.system.physics.drop and arc.system.outer_length(last.state) < OUTER_LEAST:
        return "the outer rod has run out"
    step = last.arc - before.arc
    if last.arc > 4 * step and closes(arc, first, before, last):
        return "closes"
    return ""


def closes(arc: Arc, first: Point, before: Point, last: Point) -> bool:
    """Return whether the path has come back to its first point, up to a symmetry, on its last step."""
    step = last.arc - before.arc
    if abs(first.value - last.value) > 2 * step / arc.scale or first.rate * last.rate < 0:
        return False
    if abs(first.here.energy_hat - last.here.energy_hat) > 1e-2 * (1 + abs(first.here.energy_hat)):
        return False
    weight = node_weights(arc.system.rest_lengths(last.state))
    size = math.sqrt(weight.sum())
    return (
        size * distance(last.state, first.state, weight) < 0.75 * step and last.count == first.count
    )


def stuck_words(arc: Arc, here: Point) -> str:
    """Say where no way on was found."""
    gap = arc.system.wall_gap(here.state)
    return f"no way on with the shortest steps; the wall's gap is {gap:.2g} D"


def joined(back: Path, ahead: Path) -> Path:
    """Return one path of two from the same first point, in opposite directions."""
    if len(back.points) == 1 and not back.specials:
        ahead.begins = back.ends
        return ahead
    turned = back.reversed()
    start = turned.points[-1].arc
    for point in ahead.points[1:]:
        point.arc += start
    for special in ahead.specials:
        special.arc += start
    return Path(
        ahead.name, [*turned.points, *ahead.points[1:]], [*turned.specials, *ahead.specials],
        turned.begins, ahead.ends, turned.whole and ahead.whole,
    )  # fmt: skip


def branch_points(path: Path) -> list[Special]:
    """Return the branch points and joints of a path."""
    return [special for special in path.specials if special.kind in (BRANCH_POINT, JOINT)]


def nearest_state(path: Path, value: float) -> State:
    """Return the path's state whose control is nearest to ``value``."""
    return min(path.points, key=lambda point: abs(point.value - value)).state
