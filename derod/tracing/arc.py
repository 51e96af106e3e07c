r"""The metric of a path, its points, and the step from one point to the next.

The arclength of a path in a control p is

    ds^2 = int |dx|^2 dS + ds_A^2 + ds_B^2 + |dx_C|^2 + (w dp)^2

with nodes weighed by their dual lengths: it does not depend on the mesh. w makes the control's usual step
as long as 0.02 pi D. A step predicts to second order and corrects with Newton's method on the residual and
the plane across the tangent. It is taken again, shorter, where the corrections leave the region that the
step itself spans, where the path has turned by more than TURNED, or where Newton's method is slow.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from derod.equilibrium.control import Control
from derod.equilibrium.measured import Measured, measure
from derod.equilibrium.stability import inertia
from derod.equilibrium.system import System
from derod.equilibrium.turning import turns_freely
from derod.pushing.prediction import extrapolate
from derod.rod.state import State
from derod.rod.unknowns import F_A, X_C
from derod.scene.controls import HELD
from derod.tracing.bordered import Bordered, Vector

UNIT_STEP = 0.02 * math.pi  # D, the end-shortening's usual step
MOST_ITERATIONS = 8  # of one correction
FARTHEST = 0.5  # of the step that the corrections may add up to
TURNED = 0.5  # rad that the tangent may turn in one step
BOWED = 0.08  # of a step, how far its chord may be from the mean of the tangents: beyond it is another path
LAST = 1e-10  # of the region, that the arclength's row must come to


@dataclass(slots=True, eq=False)
class Point:
    """A settled state of a path, with the path's tangent there."""

    state: State
    here: Measured
    tangent: Vector  # dz/ds: displacements and multipliers
    rate: float  # dp/ds
    weight: Vector  # the metric at the state
    arc: float = 0.0  # s, from the path's first point
    iterations: int = 0
    crossing: float = 0.0  # s2 of ``bordered``, relative; its sign changes at a branch point
    turned: float = 0.0  # rad, of the tangent since the point before

    @property
    def value(self) -> float:
        """Return the control's value, in the rod's units."""
        return self.here.control_value

    @property
    def count(self) -> int:
        """Return the number of unstable modes."""
        return self.here.unstable_modes


class Arc:
    """Steps along paths of one system in one control."""

    def __init__(self, system: System, control: Control) -> None:
        self.system, self.control = system, control
        self.bordered = Bordered(system)
        usual = HELD[control.name].step(system.scene) / system.bending**control.power
        self.scale = UNIT_STEP / usual  # w
        self.evaluations = 0  # Hessians factored

    def metric(self, state: State) -> Vector:
        """Return the metric's weights at the state measured last."""
        weight = Vector(*inertia(self.system, state))
        if not state.physics.drop:
            weight.border[: F_A + self.system.dimension] = 0.0
        return weight

    def unit(self, tangent: Vector, rate: float, weight: Vector) -> tuple[Vector, float]:
        """Return the direction scaled to length 1."""
        square = tangent.dot(weighed(weight, tangent)) + (self.scale * rate) ** 2
        return tangent.times(square**-0.5), rate * square**-0.5

    def inner(self, point: Point, tangent: Vector, rate: float) -> float:
        """Return the inner product of a direction with the tangent at a point, in its metric."""
        own = weighed(point.weight, point.tangent)
        return own.dot(tangent) + self.scale**2 * point.rate * rate

    def correct(
        self, guess: State, direction: Vector, rate: float, size: float, offset: float = 0.0
    ) -> tuple[State, int] | None:
        """Settle ``guess`` in the plane across (direction, rate), ``offset`` behind it; None where that
        fails.

        ``direction`` is weighed by the metric; ``rate`` is that of the control. ``size`` is the
        region: half of it is what corrections may add up to.
        """
        system, control, bordered = self.system, self.control, self.bordered
        state, span = guess.copy(), 0.0
        previous = math.inf
        row = self.scale**2 * rate
        for count in range(MOST_ITERATIONS + 1):
            if not system.wall_gap(state) > 0:
                return None
            residual = bordered.residual(state)
            if residual is None:
                return None
            excess, _ = system.excess(state, system.tolerance)
            if excess <= 1 and abs(offset) <= LAST * size:
                return state, count
            if count == MOST_ITERATIONS or (count > 3 and excess > 0.5 * previous):
                return None
            previous = excess
            column = bordered.linearise(state, control, direction)
            self.evaluations += 1
            if column is None:
                return None
            x1, s1 = bordered.solve(residual.times(-1.0), -offset)
            x2, s2 = bordered.solve(column, -row)
            if s2 == 0.0 or not math.isfinite(s1 / s2):
                return None
            dp = -s1 / s2
            step = x1 + x2.times(dp)
            weight = self.metric(state)
            span += math.sqrt(step.dot(weighed(weight, step)) + (self.scale * dp) ** 2)
            if not span <= FARTHEST * size:
                return None
            moved = self.moved(state, state, step, dp, 1.0, 0.0)
            if moved is None:
                return None
            offset += direction.dot(self.difference(state, moved)) + row * (
                control.value(moved) - control.value(state)
            )
            state = moved
        return None

    def moved(
        self, state: State, old: State, slope: Vector, rate: float, h: float, back: float
    ) -> State | None:
        """Return the state moved by ``h`` along a slope, to second order where ``back`` is not zero.

        None where that leaves the wall or distorts an edge (``pushing.prediction``).
        """
        slope_q = np.zeros_like(state.q)
        slope_q[1:, : state.width] = slope.rows
        last = self.system.dimension - 1
        if not state.physics.slides:
            slope_q[-1, last] = self.control.moves_end() * rate
        slope_b = slope.border[: state.b.size].copy()
        value = self.control.value(state)
        target = value + h * rate
        if back != 0.0:
            change = self.control.value(old) - value - back * rate
            target += (h / back) ** 2 * change
            bend = h / back**2  # the second order, in the path's own metric: ``turned_to``
            slope_q += bend * (old.q - state.q - back * slope_q)
            slope_b += bend * (old.b - state.b - back * slope_b)
        new = state.copy()
        for follow_wall in (False, True):
            if extrapolate(
                state.physics, self.system.room.kin, state.q, state.b, slope_q,
                slope_b, h, state.q, state.b, slope_q, slope_b, 0.0, 1, follow_wall, new.q, new.b,
            ):  # fmt: skip
                self.control.set(new, target)
                new.read_end()
                return new
        return None

    def point(self, state: State, toward: Vector, rate: float) -> Point | None:
        """Return the settled state as a point; its tangent goes the way of (toward, rate), weighed.

        None where the extended matrix is singular there.
        """
        here = measure(self.system, state, self.control)
        bordered = self.bordered
        if bordered.residual(state) is None:
            return None
        weight = self.metric(state)
        column = bordered.linearise(state, self.control, toward)
        self.evaluations += 2
        if column is None:
            return None
        row = self.scale**2 * rate
        zero = Vector(np.zeros_like(column.rows), np.zeros_like(column.border))
        x1, s1 = bordered.solve(zero, 1.0)
        x2, s2 = bordered.solve(column, -row)
        tangent, own = x1.times(s2) - x2.times(s1), -s1
        if s2 < 0:  # toward . tangent + row own = s2
            tangent, own = tangent.times(-1.0), -own
        tangent, own = self.unit(tangent, own, weight)
        size = math.sqrt(x2.dot(x2) + s2 * s2)
        return Point(state, here, tangent, own, weight, crossing=s2 / size)

    def step(
        self, point: Point, before: Point | None, size: float, region: float = 0.0
    ) -> Point | None:
        """Return the point a step of arclength ``size`` on (or back, where negative); None where it fails.

        ``region`` (arclength) is how large a step its errors are measured by, at least: beside a branch
        point rounding moves a state more than the shortest steps do.
        """
        back = 0.0 if before is None else before.arc - point.arc
        orders = (back, 0.0) if back != 0.0 and abs(size / back) <= 2.5 else (0.0,)
        direction = weighed(point.weight, point.tangent)
        old = point.state if before is None else turned_to(before.state, point)
        for reach in orders:
            guess = self.moved(point.state, old, point.tangent, point.rate, size, reach)
            if guess is not None:
                break
        else:
            return None
        region = max(abs(size), region)
        ahead = direction.dot(self.difference(point.state, guess))
        ahead += self.scale**2 * point.rate * (self.control.value(guess) - point.value)
        done = self.correct(guess, direction, point.rate, region, ahead - size)
        if done is None:
            return None
        found = self.point(done[0], direction, point.rate)
        if found is None:
            return None
        tangent, rate = self.unit(found.tangent, found.rate, point.weight)
        cosine = self.inner(point, tangent, rate)
        found.turned = math.acos(min(1.0, max(-1.0, cosine)))
        if found.turned > TURNED or self.bow(point, found, size) * abs(size) > BOWED * region:
            return None
        found.arc, found.iterations = point.arc + size, done[1]
        return found

    def difference(self, one: State, other: State) -> Vector:
        """Return what leads from one state to the other, the multipliers too."""
        border = np.zeros(self.bordered.size)
        border[: one.b.size] = other.b - one.b
        width = one.width
        return Vector(other.q[1:, :width] - one.q[1:, :width], border)

    def bow(self, point: Point, found: Point, size: float) -> float:
        """Return how far the chord of a step is from the mean of its ends' tangents, over the step.

        On one smooth path that is of second order in the turn of the tangent; on another sheet it is not
        small.
        """
        chord = self.difference(point.state, found.state)
        left = chord - (point.tangent + found.tangent).times(0.5 * size)
        rest = found.value - point.value - 0.5 * size * (point.rate + found.rate)
        square = left.dot(weighed(point.weight, left)) + (self.scale * rest) ** 2
        return math.sqrt(square) / abs(size)


def turned_to(old: State, point: Point) -> State:
    """Return a state turned about the axis to where it is nearest to a point, if turning is free there.

    Else a prediction of second order, which holds the turn between two states against the tangent, would
    amplify it.
    """
    state = point.state
    if not turns_freely(state):
        return old
    share = point.weight.rows[:, 0]
    here, there = (one.q[1:, 0] + 1j * one.q[1:, 1] for one in (state, old))
    center, other = (complex(one.b[X_C], one.b[X_C + 1]) for one in (state, old))
    overlap = np.sum(share * there.conj() * here) + other.conjugate() * center
    if abs(overlap) < 1e-20:
        return old
    turn = overlap / abs(overlap)
    out = old.copy()
    nodes = (old.q[:, 0] + 1j * old.q[:, 1]) * turn
    out.q[:, 0], out.q[:, 1] = nodes.real, nodes.imag
    out.b[X_C], out.b[X_C + 1] = (other * turn).real, (other * turn).imag
    return out


def weighed(weight: Vector, vector: Vector) -> Vector:
    """Return the metric times a vector."""
    return Vector(weight.rows * vector.rows, weight.border * vector.border)
