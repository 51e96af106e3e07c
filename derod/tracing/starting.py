"""Where a path may start: any settled state. And where it may be looked at: any value of its control."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.interpolate import CubicSpline

from derod.equilibrium.implicit import Implicit
from derod.equilibrium.loop import relax
from derod.equilibrium.measured import Measured, measure
from derod.equilibrium.system import System
from derod.rod.arrays import new_q
from derod.rod.state import State
from derod.rod.unknowns import BORDER, ETA, F_A, S_A, S_B, X_C
from derod.tracing.arc import Arc, Point, weighed
from derod.tracing.bordered import Vector
from derod.tracing.path import Limits, Path, Watch, follow, joined
from derod.tracing.special import between

HEAVY = 1e8  # K0/D^4
ROOTS = 60  # bisections of Hermite's cubic


def start_point(arc: Arc, state: State, rising: bool = True) -> Point | None:
    """Return a settled state as a path's first point, its control rising along the path or falling."""
    here = measure(arc.system, state, arc.control)
    weight = arc.metric(state)
    slope = Vector(here.slope_q[1:, : state.width].copy(), weight.border * 0.0)
    slope.border[: state.b.size] = here.slope_b
    tangent, rate = arc.unit(slope, 1.0, weight)
    sign = 1.0 if rising else -1.0
    return arc.point(state, weighed(weight, tangent.times(sign)), sign * rate)


def both_ways(
    arc: Arc, state: State, limits: Limits, name: str = "", watch: Watch | None = None
) -> Path | None:
    """Follow the path through a settled state to both of its ends; None where it has no tangent there."""
    ahead, back = start_point(arc, state), start_point(arc, state, rising=False)
    if ahead is None or back is None:
        return None
    first = follow(arc, back, limits, name, watch)
    if first.ends == "closes":
        return first
    return joined(first, follow(arc, ahead, limits, name, watch))


@dataclass(frozen=True, slots=True)
class Sheet:
    """A settled state of a path at a value of its control."""

    path: str
    arc: float
    state: State
    here: Measured


def sheets(arc: Arc, path: Path, value: float) -> list[Sheet]:
    """Return the path's states at a value of the control, settled there, one for each time it passes it."""
    out = []
    for a, b in zip(path.points, path.points[1:], strict=False):
        if not min(a.value, b.value) <= value <= max(a.value, b.value) or b.value == value:
            continue
        place = crossing(a, b, value)
        found = landed(arc, between(arc, a, b, place), value)
        if found is not None:
            out.append(Sheet(path.name, place, found, measure(arc.system, found, arc.control)))
    return out


def landed(arc: Arc, guess: State, value: float) -> State | None:
    """Return the state near ``guess`` at a value of the control, None where none is found."""
    state = guess.copy()
    arc.control.set(state, value)
    solution = relax(Implicit(), arc.system, state)
    return solution.state if solution.converged else None


def crossing(a: Point, b: Point, value: float) -> float:
    """Return the arclength at which the control has a value, by bisection of Hermite's cubic."""
    span = b.arc - a.arc
    low, high = 0.0, 1.0

    def off(u: float) -> float:
        near, far = (1 + 2 * u) * (1 - u) ** 2, u * u * (3 - 2 * u)
        own, other = u * (1 - u) ** 2 * span, u * u * (u - 1) * span
        return near * a.value + far * b.value + own * a.rate + other * b.rate - value

    rises = off(1.0) > off(0.0)
    for _ in range(ROOTS):
        middle = 0.5 * (low + high)
        if (off(middle) > 0) == rises:
            high = middle
        else:
            low = middle
    return a.arc + 0.5 * (low + high) * span


def with_multipliers(system: System, state: State) -> None:
    """Give a state whose shape alone is known the tensions and menisci's forces that balance it best, in
    place.

    A shift that outweighs the Hessian makes its solution that of least squares for the multipliers.
    """
    d = system.dimension
    system.linearise(state, HEAVY)
    right = np.zeros((system.edges, system.width))
    right[:-1, :d] = -system.room.r[1:-1, :d]
    border = np.zeros_like(system.factor.rhs_border)
    border[: F_A + d] = -system.room.rb[: F_A + d]
    step, more = system.solve(right, border)
    state.q[1:, d] += step[:, d]
    state.b[F_A + d :] += more[F_A + d : state.b.size]


def from_shape(
    system: System, arc_length: np.ndarray, positions: np.ndarray, drop: np.ndarray,
    menisci: tuple[float, float],
) -> State:  # fmt: skip
    """Return an unsettled state of a given centre line.

    ``arc_length`` (k,) and ``positions`` (k, 3) in D, the clamp axis along e_z; ``drop`` its centre (3,),
    ``menisci`` s_A, s_B. Its end-shortening is where the end lies.
    """
    d, physics = system.dimension, system.physics
    state = State(new_q(system.edges, physics), np.zeros(BORDER + d), 0.0, 0.0, physics)
    state.b[S_A], state.b[S_B] = menisci
    state.b[X_C : F_A + d] = drop[3 - d :]
    nodes = system.arc_length(state)
    for k in range(d):
        state.q[:, k] = CubicSpline(arc_length, positions[:, 3 - d + k])(nodes)
    state.q[0, :d] = 0.0
    state.clamp_at(float(physics.length - positions[-1, 2]))
    state.b[F_A + d : ETA + d] = physics.capillary_force
    return state
