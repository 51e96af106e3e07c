"""The piece of a branch between two stored points, as a function of its projection on their chord.

U(x), 0 <= x <= L: the kept unknowns (37) whose projection on the chord from the start to the other
point is x. Steps along a path turn its tangent by less than 0.75 rad, so that this is one state for
each x, folds and all; and planar states lie at x = L only where the other point is a pitchfork that
the space path leaves the plane at, however flat the path is there. Held end-shortening is neither.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from derod.branches.half_rod import closure as col
from derod.branches.half_rod.fields import evaluate_fields
from derod.branches.half_rod.linear import Reduced, linearise
from derod.branches.half_rod.mirror import FULL, PLANES, Mirror
from derod.branches.half_rod.observables import observables
from derod.branches.half_rod.outcome import NotConverged
from derod.branches.half_rod.state import HalfRod
from derod.branches.half_rod.symmetry import nearest_image, plane
from derod.branches.paths.arc import frozen, metric
from derod.branches.paths.newton import Settled, settle
from derod.branches.paths.tabulated import Tabulated

TOLERANCE = 1e-10
LEAST_STEP = 1e-3
"""Shortest substep, as a share of the interval."""
OFF_CHORD = 0.5
"""Distance from the chord, as a share of its length, at which a state is on another branch."""
LEAST_AMPLITUDE = 0.25
"""Share of the out-of-plane amplitude that is linear along the chord, below which a state is flat."""
ENERGY_SLACK = 1e-6
_BY_NAME = {m.name: m for pair in PLANES for m in pair} | {FULL.name: FULL}


@dataclass(frozen=True)
class Place:
    """A solved state of an interval: its projection x and the derivative of the state by x."""

    x: float
    settled: Settled
    rate: np.ndarray  # (37,) dU/dx

    @property
    def state(self) -> HalfRod:
        """The half rod."""
        return self.settled.state

    @property
    def slope(self) -> float:
        """d delta/dx."""
        return float(self.rate[col.DELTA])


def mirror_of(branch: Tabulated) -> Mirror:
    """The mirror class of a stored branch."""
    return _BY_NAME[branch.mirror]


def solved(branch: Tabulated, i: int) -> Settled:
    """Stored point i solved to TOLERANCE, its stages too; on a joint in the joint's plane.

    Held is the component along the path's own tangent, so that folds are no exception. Raises
    NotConverged.
    """
    state = branch.state(i)
    mirror = mirror_of(branch)
    flat = plane(state) if mirror is FULL else None
    if flat is not None:
        mirror = flat[0]
    for _ in range(2):  # the stages' guess is rough: the tangent is taken again
        matrix = Reduced(linearise(state), mirror).matrix
        columns = np.concatenate([mirror.kept, [col.DELTA]])
        row = np.zeros(col.KEPT)
        row[columns] = np.linalg.svd(matrix[:, columns])[2][-1]
        closing = np.stack([frozen(col.FGAMMA), row])
        settled = settle(state, mirror, closing, closing @ state.kept, TOLERANCE, 16)
        state = settled.state
    return settled


class Interval:
    """The path between the stored points ``index`` and ``index + 1`` of a branch.

    Walked from its end that is no joint (the nearer to ``delta`` where neither is). Raises
    NotConverged where that end cannot be solved again.
    """

    def __init__(self, branch: Tabulated, index: int, delta: float) -> None:
        self.branch, self.index = branch, index
        self.mirror = mirror_of(branch)
        pair = (branch.state(index), branch.state(index + 1))
        flat = [plane(state) if self.mirror is FULL else None for state in pair]
        gaps = [abs(state.end_shortening - delta) for state in pair]
        first = int(gaps[1] < gaps[0])
        if (flat[0] is None) != (flat[1] is None):
            first = int(flat[0] is not None)
        elif flat[0] is not None:
            raise NotConverged(f"points {index} and {index + 1} are both planar")
        self.joint = flat[1 - first]
        self.sense = 1 if first == 0 else -1
        self.first, self.second = index + first, index + 1 - first
        self.weights = metric(float(pair[first].scalars[5]))
        start = solved(branch, self.first)
        self.origin = start.state.kept
        other = pair[1 - first].kept
        if self.joint is not None:
            other = nearest_image(other, self.origin, self.weights)
        chord = other - self.origin
        self.length = float(np.sqrt(self.weights @ chord**2))
        if self.length == 0.0:
            raise NotConverged(f"points {index} and {index + 1} are the same")
        self.direction = chord / self.length
        self.closing = np.stack([frozen(col.FGAMMA), self.weights * self.direction])
        self.force = float(start.state.scalars[5])
        self.known = [self._place(0.0, start)]

    @cached_property
    def ends(self) -> np.ndarray:
        """Stored rows of the start and of the other point."""
        return self.branch.table[[self.first, self.second]]

    def values(self, x: float) -> np.ndarray:
        """Right-hand sides (2,) of ``closing`` at x."""
        return np.array([self.force, float(self.closing[1] @ self.origin) + x])

    def _place(self, x: float, settled: Settled) -> Place:
        reduced = settled.reduced
        if reduced.mirror is not self.mirror:
            reduced = Reduced(reduced.elements, self.mirror)
        rate = reduced.solve(self.closing, np.array([[0.0, 1.0, 0.0]]))[0]
        return Place(x, settled, rate)

    def at(self, x: float) -> Place:
        """The state at x, continued from the nearest one known. Raises NotConverged."""
        while True:
            near = min(self.known, key=lambda place: abs(place.x - x))
            if near.x == x:
                return near
            step = x - near.x
            while True:
                try:
                    self.known.append(self._step(near, near.x + step))
                    break
                except NotConverged:
                    step *= 0.5
                    if abs(step) < LEAST_STEP * self.length:
                        raise
            if step == x - near.x:
                return self.known[-1]

    def _step(self, near: Place, x: float) -> Place:
        increment = near.settled.reduced.expand(near.rate, 0.0)
        predicted = near.state.moved(increment, x - near.x)
        if not evaluate_fields(predicted).gap > 0.0:
            raise NotConverged("the prediction lies outside the wall")
        place = self.solve(predicted, x)
        self.check(place)
        return place

    def solve(self, guess: HalfRod, x: float) -> Place:
        """The state at x from a guess, on the guess's mesh. Raises NotConverged."""
        return self._place(x, settle(guess, self.mirror, self.closing, self.values(x), TOLERANCE))

    def check(self, place: Place) -> None:
        """Raise NotConverged where a state is not on the path between the two points.

        It must be near the chord, and keep its share of what leads out of the joint's plane.
        """
        away = place.state.kept - self.origin - place.x * self.direction
        distance = float(np.sqrt(self.weights @ away**2))
        if distance > OFF_CHORD * self.length:
            raise NotConverged(
                f"{distance:.1e} off the chord of points {self.index} and {self.index + 1}, "
                f"{self.length:.1e} apart"
            )
        if self.joint is not None:
            odd = self.joint[1].kept
            amplitude = place.state.kept[odd] @ self.origin[odd] / np.sum(self.origin[odd] ** 2)
            share = 1.0 - place.x / self.length
            if amplitude < LEAST_AMPLITUDE * share:
                raise NotConverged(
                    f"flat ({amplitude:.1e} of point {self.first}'s amplitude) beside the joint"
                )

    def check_energy(self, state: HalfRod) -> None:
        """Raise NotConverged where dE_hat/ddelta = f_gamma - t does not hold from the start on.

        The energy gained must lie within what the tensions met on the way would give.
        """
        own, start = observables(state), observables(self.known[0].state)
        unit = self.branch.parameters.bending
        tensions = [own["end_tension"], *(self.ends["end_tension"] / unit)]
        spread = max(tensions) - min(tensions)
        moved = own["end_shortening"] - start["end_shortening"]
        mean = 0.5 * (own["end_tension"] + start["end_tension"])
        left = own["energy_hat"] - start["energy_hat"] - (self.force - mean) * moved
        if abs(left) > abs(moved) * spread + ENERGY_SLACK * max(1.0, abs(own["energy_hat"])):
            raise NotConverged(f"E_hat is off the branch by {left:.1e} beside point {self.first}")
