"""Pseudo-arclength steps along a path of half-rod states."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from derod.branches.half_rod import closure as col
from derod.branches.half_rod.fields import evaluate_fields
from derod.branches.half_rod.mesh import RESOLUTION, adapted, drifted
from derod.branches.half_rod.mirror import FULL, Mirror, planes
from derod.branches.half_rod.outcome import NotConverged
from derod.branches.half_rod.state import HalfRod, Increment
from derod.branches.paths.newton import Settled, settle

FLAT = 1e-7
"""Share of a space curve's out-of-plane unknowns below which a step has left its path."""


def metric(capillary_force: float) -> np.ndarray:
    """Squared weights (37,) of the kept unknowns in the arclength.

    Lengths and quaternions count as they are, forces in units of f_gamma, moments of f_gamma D / 2.
    """
    node = np.array([1.0] * 7 + [1.0 / capillary_force] * 3)
    unit = 1.0 / capillary_force
    moment = 2.0 / capillary_force
    scalars = [moment, moment, 0.2, 1.0, 1.0, unit, unit]
    return np.concatenate([node, node, node, scalars]) ** 2


def frozen(column: int) -> np.ndarray:
    """The closing row (37,) that holds one kept unknown."""
    row = np.zeros(col.KEPT)
    row[column] = 1.0
    return row


@dataclass(frozen=True)
class Control:
    """Tolerance and step control of a continuation; steps are arclengths in the metric."""

    tolerance: float = 1e-10
    first_step: float = 0.02
    largest_step: float = 0.22
    least_step: float = 1e-6
    turning: float = 0.25  # angle between successive tangents at which steps stop growing
    iterations: int = 4
    accuracy: float = 1e-8  # mesh-halving error allowed in a stored point
    resolution: float = RESOLUTION


@dataclass
class Point:
    """A settled state on a path, its tangent and the path's arclength up to it."""

    settled: Settled
    tangent: np.ndarray  # (37,), of metric length one
    arc: float
    increment: Increment = field(init=False)

    def __post_init__(self) -> None:
        self.increment = self.settled.reduced.expand(self.tangent, 0.0)

    @property
    def state(self) -> HalfRod:
        """The settled state."""
        return self.settled.state

    @property
    def fold_function(self) -> float:
        """d delta/d arclength, zero at a fold."""
        return float(self.tangent[col.DELTA])


class Tracer:
    """Steps along one path.

    ``held``: which of delta, f_gamma and W do not change. One of them: W does not change either
    and is no unknown. Two: W is the third's partner among the unknowns.
    """

    def __init__(
        self,
        mirror: Mirror,
        control: Control,
        capillary_force: float,
        held: tuple[int, ...] = (col.FGAMMA,),
    ) -> None:
        self.mirror = mirror
        self.control = control
        self.metric = metric(capillary_force)
        self.held = held

    def begin(self, settled: Settled, direction: np.ndarray, arc: float = 0.0) -> Point:
        """A path's first point, its tangent on the side of ``direction`` (37,)."""
        values = np.array([[*(0.0 for _ in self.held), 1.0, 0.0]])
        tangent = settled.reduced.solve(self.closing(direction), values)[0]
        return Point(settled, tangent / np.sqrt(self.metric @ tangent**2), arc)

    def closing(self, direction: np.ndarray) -> np.ndarray:
        """The closing rows (held + 1, 37): what is held, and the projection on ``direction``."""
        return np.stack([*(frozen(column) for column in self.held), self.metric * direction])

    def advance(
        self, point: Point, length: float, previous: Point | None = None, remesh: bool = True
    ) -> Point:
        """The settled point whose projection on ``point``'s tangent lies ``length`` further.

        ``previous`` (the point before, on the same mesh) makes the prediction second order. Raises
        NotConverged.
        """
        predicted = point.state.moved(point.increment, length)
        if previous is not None and _same_mesh(previous.state, point.state):
            span = point.arc - previous.arc
            curve = 0.5 * length * length / span
            predicted = predicted.moved(point.increment, curve).moved(previous.increment, -curve)
        if not evaluate_fields(predicted).gap > 0.0:
            raise NotConverged("the prediction lies outside the wall")
        if remesh and drifted(predicted, self.control.resolution):
            predicted = adapted(predicted, self.control.resolution)
        closing = self.closing(point.tangent)
        values = closing @ point.state.kept
        values[-1] += length
        settled = settle(predicted, self.mirror, closing, values, self.control.tolerance)
        return self.begin(settled, point.tangent, point.arc + length)

    def march(self, start: Point, stop, limit: int = 2000):  # type: ignore[no-untyped-def]
        """Yield points from ``start`` on until ``stop(point)`` gives a reason or steps vanish.

        Returns the reason (generator's value).
        """
        yield start
        reason = stop(start)
        point, previous = start, None
        length = self.control.first_step
        for _ in range(limit):
            if reason:
                return reason
            try:
                new = self.advance(point, length, previous)
            except NotConverged as error:
                length *= 0.5
                if length < self.control.least_step:
                    return f"no convergence: {error}"
                continue
            if self.mirror is FULL and fell_flat(point.state, new.state):
                length *= 0.5
                if length < self.control.least_step:
                    return "a space path that falls onto a planar one"
                continue
            cosine = float(np.clip(self.metric @ (new.tangent * point.tangent), -1.0, 1.0))
            angle = float(np.arccos(cosine))
            if angle > 3.0 * self.control.turning and length > 100.0 * self.control.least_step:
                length *= 0.5
                continue
            previous, point = point, new
            yield point
            reason = stop(point)
            growth = min(
                2.0,
                1.5 * (self.control.iterations + 0.5 - new.settled.iterations + 1.0) / 2.0,
                self.control.turning / max(angle, 1e-9),
            )
            length = min(length * max(growth, 0.4), self.control.largest_step)
        return f"more than {limit} points"


def fell_flat(before: HalfRod, after: HalfRod) -> bool:
    """Whether a step from a space curve ended on a planar path: its out-of-plane unknowns vanish."""
    for _, odd in planes(before.weight):
        size = float(np.linalg.norm(before.kept[odd.kept]))
        if float(np.linalg.norm(after.kept[odd.kept])) < FLAT * size:
            return True
    return False


def _same_mesh(a: HalfRod, b: HalfRod) -> bool:
    return a.eta is b.eta
