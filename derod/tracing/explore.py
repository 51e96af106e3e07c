"""All paths of a scene within limits: from the straight rod, switching at every bifurcation, each path
once.

Paths that do not hang together with the straight rod are looked for under a stronger capillary force: what
buckles there is followed to an end-shortening, and the force is lowered to the scene's.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace

from derod.pushing.controls import CONTROLS
from derod.rod.state import State
from derod.tracing.arc import Arc, Point
from derod.tracing.path import Limits, Path, branch_points, follow
from derod.tracing.special import BRANCH_POINT, JOINT, Special, between
from derod.tracing.starting import both_ways, crossing, landed, start_point
from derod.tracing.straight import buckled, bucklings
from derod.tracing.switching import is_mirrored, is_transcritical, switch
from derod.tracing.symmetry import SAME, distance, node_weights

CLOSE_ENERGY, CLOSE_TENSION = (
    2e-3,
    2e-2,
)  # relative, of states that may be one: a closer look decides
SLACK = (
    1e-3  # of the capillary force: the least end tension that the straight rod is looked at under
)
BESIDE = (
    0.01  # D of the norm, likewise beyond its ends: another leap may begin nearer to a branch point
)
NEAR = 0.3  # of a step beyond a segment's ends, where a path is still looked for
UNTRIED, TRIED, KNOWN = "", "followed", "known"
LOST, BEYOND = "no state found beside it", "beyond the limit of energy"


@dataclass(frozen=True, slots=True)
class Bounds:
    """What an exploration keeps within."""

    limits: Limits
    paths: int = 60
    buckled: int = 3  # modes of the straight rod
    strong: float = (
        6.0  # times the capillary force, to find disconnected paths; 0: they are not looked for
    )
    lowered_at: float = 1.1 * math.pi  # D, the end-shortening at which the force is lowered
    modes: int = 3  # modes of the straight rod under the strong force


Tell = Callable[[str], None]


@dataclass
class Exploration:
    """What has been found, and what is still to be done."""

    arc: Arc
    bounds: Bounds
    tell: Tell = lambda line: None
    save: Callable[[], None] = lambda: None
    paths: list[Path] = field(default_factory=list)
    stages: set[str] = field(default_factory=set)  # that are done: "straight", "strong"
    complete: bool = False

    def run(self) -> None:
        """Go on until nothing is left to be done, or as many paths as are wanted have been found."""
        for stage, begin in (("straight", self.from_straight), ("strong", self.from_strong)):
            if stage not in self.stages:
                begin()
                self.stages.add(stage)
                self.save()
        self.switch_all()
        self.complete = self.next_special() is None
        self.save()

    def full(self) -> bool:
        """Return whether as many paths as are wanted have been found."""
        return len(self.paths) >= self.bounds.paths

    def from_straight(self) -> None:
        """Follow what leaves the straight rod."""
        system = self.arc.system
        least = SLACK * system.physics.capillary_force if system.physics.drop else None
        for found in bucklings(system, self.bounds.buckled, least):
            first = None if self.full() else buckled(self.arc, found)
            if first is not None and self.known(first) is None:
                path = follow(self.arc, first, self.bounds.limits, self.name())
                path.begins = f"the straight rod buckles at the end tension {found.tension:.8g}"
                self.add(path)

    def from_strong(self) -> None:
        """Follow what buckles under a stronger capillary force, and lower that."""
        system, bounds = self.arc.system, self.bounds
        usual = system.physics
        force = usual.capillary_force
        at = bounds.lowered_at
        if bounds.strong <= 1 or not usual.drop:
            return
        if not bounds.limits.low < at < bounds.limits.high:
            return
        system.physics = usual._replace(capillary_force=bounds.strong * force)
        try:
            firsts = [
                buckled(self.arc, one) for one in bucklings(system, bounds.modes, SLACK * force)
            ]
            ways = [
                follow(self.arc, first, replace(bounds.limits, high=at, energy_hat=float("inf")))
                for first in firsts
                if first is not None
            ]
        finally:
            system.physics = usual
        lowering = Arc(system, CONTROLS["capillary_force"])
        for way in ways:
            a, b = way.points[-2:]
            if self.full() or not min(a.value, b.value) <= at <= max(a.value, b.value):
                continue
            state = landed(self.arc, between(self.arc, a, b, crossing(a, b, at)), at)
            lowered = None if state is None else both_ways(
                lowering, state,
                replace(
                    bounds.limits, low=force, high=1.001 * bounds.strong * force, energy_hat=math.inf
                ),
            )  # fmt: skip
            if lowered is None:
                continue
            for a, b in zip(lowered.points, lowered.points[1:], strict=False):
                if not min(a.value, b.value) <= force <= max(a.value, b.value):
                    continue
                state = landed(lowering, between(lowering, a, b, crossing(a, b, force)), force)
                if state is not None and not self.full():
                    state.physics = usual._replace(slides=False)
                    self.add_through(state)

    def add_through(self, state: State) -> None:
        """Follow the path through a settled state both ways, unless it is known."""
        point = start_point(self.arc, state)
        if point is None or point.here.energy_hat > self.bounds.limits.energy_hat:
            return
        if self.known(point) is not None:
            return
        path = both_ways(self.arc, state, self.bounds.limits, self.name())
        if path is not None:
            self.add(path)

    def switch_all(self) -> None:
        """Switch at every branch point that has not been tried, those of low energy first."""
        while not self.full():
            found = self.next_special()
            if found is None:
                return
            self.switch(*found)
            self.save()

    def next_special(self) -> tuple[Path, Special] | None:
        """Return the untried branch point of the lowest energy, and its path."""
        waiting = [
            (special.point.here.energy_hat, i, k)
            for i, path in enumerate(self.paths)
            for k, special in enumerate(path.specials)
            if special.kind in (BRANCH_POINT, JOINT) and special.fate == UNTRIED
        ]
        if not waiting:
            return None
        _, i, k = min(waiting)
        return self.paths[i], self.paths[i].specials[k]

    def switch(self, path: Path, special: Special) -> None:
        """Follow what meets a path at a branch point."""
        sides = [switch(self.arc, special)]
        special.symmetric = special.kind == JOINT or is_mirrored(special)
        if special.kind == JOINT or not special.symmetric:
            sides.append(switch(self.arc, special, -1.0))
        if special.kind != JOINT and None not in sides and len(sides) == 2:
            one, other = sides
            assert one is not None and other is not None
            special.symmetric = not is_transcritical(special, one, other)
        points = [point for point in sides if point is not None]
        if points and all(p.here.energy_hat > self.bounds.limits.energy_hat for p in points):
            special.fate = BEYOND
            return
        if not points:
            special.fate = LOST
            return
        for point in points:
            name = self.known(point)
            if name is not None:
                special.partner, special.fate = name, KNOWN
                return
        parts = [follow(self.arc, point, self.bounds.limits, self.name()) for point in points]
        new = parts[0]
        if len(parts) == 2:
            new = spliced(*parts)
        else:
            new.begins = f"branches off {path.name}"
        special.partner, special.fate = new.name, TRIED
        self.add(new)

    def known(self, point: Point) -> str | None:
        """Return the name of the path that a point lies on, up to the symmetries, or None."""
        arc = self.arc
        for path in self.paths:
            last = len(path.points) - 2
            for i, (a, b) in enumerate(zip(path.points, path.points[1:], strict=False)):
                low, high = sorted((a.value, b.value))
                reach = NEAR * (high - low) + (BESIDE / arc.scale if i in (0, last) else 1e-12)
                if not low - reach <= point.value <= high + reach:
                    continue
                if not alike(point, a, b):
                    continue
                place = crossing(a, b, point.value)
                state = landed(arc, between(arc, a, b, place), point.value)
                if state is None:
                    continue
                weight = node_weights(arc.system.rest_lengths(state))
                if distance(state, point.state, weight) < 10 * SAME:
                    return path.name
        return None

    def name(self) -> str:
        """Return the next path's name."""
        return f"P{len(self.paths) + 1}"

    def add(self, path: Path) -> None:
        """Take in a path, and say so."""
        self.paths.append(path)
        low = min(point.value for point in path.points)
        high = max(point.value for point in path.points)
        stable = sum(point.count == 0 for point in path.points)
        self.tell(
            f"{path.name}: {len(path.points)} points, {stable} stable, {low:.6g} to {high:.6g}; "
            f"{len(branch_points(path))} branch points; {path.ends}"
        )
        self.save()


def alike(point: Point, a: Point, b: Point) -> bool:
    """Return whether a point's energy and tension are near those of a segment."""
    for name, relative in (("energy_hat", CLOSE_ENERGY), ("tension", CLOSE_TENSION)):
        own, one, other = (getattr(p.here, name) for p in (point, a, b))
        low, high = sorted((one, other))
        reach = relative * (1 + abs(own)) + NEAR * (high - low)
        if not low - reach <= own <= high + reach:
            return False
    return True


def spliced(ahead: Path, back: Path) -> Path:
    """Return one path of two that lead away from a branch point on its two sides."""
    turned = back.reversed()
    gap = abs(ahead.points[0].value - turned.points[-1].value)
    start = turned.points[-1].arc + max(gap, 1e-6)
    for point in ahead.points:
        point.arc += start
    for special in ahead.specials:
        special.arc += start
    return Path(
        ahead.name, [*turned.points, *ahead.points], [*turned.specials, *ahead.specials],
        turned.begins, ahead.ends, turned.whole and ahead.whole,
    )  # fmt: skip
