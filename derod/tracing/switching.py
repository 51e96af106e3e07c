r"""Onto the branches that meet at a branch point, and off the straight rod.

At a branch point the null mode phi leaves the path; a state on the other branch is sought in the plane at
the distance eps along phi, made perpendicular to the path's own tangent. At a joint the mode is the
tangent itself, and the crossing path's direction comes from the Hessian with the mode's row: [[K, M phi],
[phi^T M, 0]] (z', s) = (c, 0).
"""

from __future__ import annotations

import math

import numpy as np

from derod.pushing.kicks import breaks_a_symmetry
from derod.tracing.arc import Arc, Point, weighed
from derod.tracing.bordered import Vector
from derod.tracing.special import JOINT, Special

LEAPS = (0.05, 0.02, 0.008, 0.003, 0.001)  # D in the path's norm, tried in turn
REGION = 2.0  # of the leap, what corrections are held to
DRIFT = 0.05  # of the control between the two sides, over the leap: a transcritical point


def switch(arc: Arc, special: Special, side: float = 1.0) -> Point | None:
    """Return a point on the other branch through a branch point, on one side; None where none is found."""
    if special.kind == JOINT:
        return cross(arc, special, side)
    if special.mode is None:
        return None
    point, mode, rate = special.point, special.mode, 0.0
    if not is_mirrored(special):
        own = arc.inner(point, mode, 0.0)
        mode, rate = mode - point.tangent.times(own), -own * point.rate
    mode, rate = arc.unit(mode, rate, point.weight)
    return first_beside(arc, special, mode.times(side), rate * side)


def first_beside(arc: Arc, special: Special, mode: Vector, rate: float) -> Point | None:
    """Settle a state beside a special point, in the plane across a direction; None where no leap succeeds."""
    direction = weighed(special.point.weight, mode)
    for leap in LEAPS:
        arc.system.gradient(special.base)
        guess = arc.moved(special.base, special.base, mode, rate, leap, 0.0)
        if guess is None:
            continue
        done = arc.correct(guess, direction, rate, REGION * leap)
        found = None if done is None else arc.point(done[0], direction, rate)
        if found is not None:
            return found
    return None


def cross(arc: Arc, special: Special, side: float) -> Point | None:
    """Return a point on the path that a joint lies on, on one side of it."""
    bordered, weight = arc.bordered, special.point.weight
    if special.mode is None or bordered.residual(special.base) is None:
        return None
    column = bordered.linearise(special.base, arc.control, weighed(weight, special.mode))
    if column is None:
        return None
    slope, _ = bordered.solve(column, 0.0)
    slope, rate = arc.unit(slope, 1.0, weight)
    return first_beside(arc, special, slope.times(side), rate * side)


def is_mirrored(special: Special) -> bool:
    """Return whether the two sides of a branch point are images of each other: a pitchfork."""
    if special.mode is None:
        return True
    state = special.base
    mode = np.zeros_like(state.q)
    mode[1:, : state.width] = special.mode.rows
    return breaks_a_symmetry(state, mode, state.physics.end_rotation - state.holonomy)


def is_transcritical(special: Special, one: Point, other: Point) -> bool:
    """Return whether the control differs between the two sides to first order."""
    leap = math.sqrt(abs(one.value - special.value) * abs(other.value - special.value))
    return abs(one.value - other.value) > DRIFT * max(leap, 1e-12) and (
        (one.value - special.value) * (other.value - special.value) < 0
    )
