"""Extrapolate a state along its branch, and tell whether what comes out may be relaxed from."""

from __future__ import annotations

import numpy as np

from derod.algebra.jit import inlined, kernel
from derod.rod.assembly import turns_freely
from derod.rod.terms.wall import stay_inside, wall_gap
from derod.rod.unknowns import S_A, S_B, X_C

FARTHEST = 0.25  # D a node may be predicted to move
MOST_CHANGE = (
    0.6  # of an edge's length by which it may be predicted to change: strain, and turn in radians
)
LEAST_GAP = 0.2  # of the wall's gap that a prediction must leave
TELLING = 1e-7  # D, the least that the third order must add to the second


@kernel
def extrapolate(
    physics, kin, q, b, slope, slope_b, h, old_q, old_b, old_slope, old_slope_b, back, order,
    follow_wall, new_q, new_b,
):  # fmt: skip
    """Fill (new_q, new_b), a step ``h`` from (q, b) along its slope; return whether it is sound.

    To first, second or third ``order``: the second takes in the old state, a step ``back`` away, the third
    its slope too (Hermite's cubic), both turned about the clamp axis onto the present one where the turn is
    neutral: how far the coil has turned between them is no property of the branch. The third order repeats
    five times over what a tolerance left in two states, so it must tell more than that. ``follow_wall`` puts
    nodes back that ran into the wall's curve. A prediction is sound that stays inside the wall and the rod,
    moves no node too far, and keeps every edge near its length and direction.
    """
    d = len(physics.axis)
    cosine, sine = turn_onto(physics, old_q, q)
    added = 0.0
    for i in range(q.shape[0]):
        for k in range(len(physics.row)):
            moved = turned(old_q[i], k, 0, cosine, sine) - q[i, k]
            veered = turned(old_slope[i], k, 0, cosine, sine)
            step = change(h, slope[i, k], back, moved, veered, order)
            new_q[i, k] = q[i, k] + step
            if order == 3 and k < d:
                lower = change(h, slope[i, k], back, moved, veered, 2)
                added = max(added, abs(step - lower))
    if order == 3 and added < TELLING:
        return False
    for k in range(b.size):
        moved = turned(old_b, k, X_C, cosine, sine) - b[k]
        veered = turned(old_slope_b, k, X_C, cosine, sine)
        new_b[k] = b[k] + change(h, slope_b[k], back, moved, veered, order)
    if follow_wall:
        stay_inside(physics, kin, q, b, new_q, new_b)
    gap = wall_gap(physics, kin, q, b)
    if not wall_gap(physics, kin, new_q, new_b) > LEAST_GAP * gap:
        return False
    if physics.drop and not (new_b[S_A] > 0 and physics.length > new_b[S_B] > new_b[S_A]):
        return False
    for i in range(1, q.shape[0]):
        square, changed = 0.0, 0.0
        for k in range(d):
            edge = q[i, k] - q[i - 1, k]
            square += edge * edge
            changed += (new_q[i, k] - new_q[i - 1, k] - edge) ** 2
            if not abs(new_q[i, k] - q[i, k]) < FARTHEST:
                return False
        if not changed < MOST_CHANGE * MOST_CHANGE * square:
            return False
    return True


@inlined
def change(h, slope, back, moved, old_slope, order):
    """Return the change over a step ``h`` of a number that was ``moved`` away, a step ``back`` from here."""
    if order == 1:
        return h * slope
    ratio = h / back
    if order == 2:
        return h * slope + ratio * ratio * (moved - back * slope)
    second = 3 * moved - back * (2 * slope + old_slope)
    third = back * (slope + old_slope) - 2 * moved
    return h * slope + ratio * ratio * (second + ratio * third)


@inlined
def turn_onto(physics, old_q, q):
    """Return cosine and sine of the turn about the clamp axis that brings the old nodes nearest to q.

    Exactly 1 and 0 where the turn is not neutral, in the plane, and where all lies in a plane.
    """
    along, across = 0.0, 0.0
    if len(physics.axis) == 3 and turns_freely(physics):
        for i in range(q.shape[0]):
            along += old_q[i, 0] * q[i, 0] + old_q[i, 1] * q[i, 1]
            across += old_q[i, 0] * q[i, 1] - old_q[i, 1] * q[i, 0]
    length = np.sqrt(along * along + across * across)
    if not along > 0.0:
        return 1.0, 0.0
    return along / length, across / length


@inlined
def turned(values, k, first, cosine, sine):
    """Return component k of ``values`` after a turn of its components ``first`` and the one after it."""
    if k == first:
        return cosine * values[k] - sine * values[k + 1]
    if k == first + 1:
        return sine * values[k - 1] + cosine * values[k]
    return values[k]
