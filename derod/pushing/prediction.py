"""Extrapolate a state along its branch, and tell whether what comes out may be relaxed from."""

from __future__ import annotations

from derod.algebra.jit import kernel
from derod.rod.terms.wall import stay_inside, wall_gap
from derod.rod.unknowns import S_A, S_B

FARTHEST = 0.25  # D a node may be predicted to move
MOST_CHANGE = (
    0.6  # of an edge's length by which it may be predicted to change: strain, and turn in radians
)
LEAST_GAP = 0.2  # of the wall's gap that a prediction must leave


@kernel
def extrapolate(
    physics, kin, q, b, slope, slope_b, h, old_q, old_b, back, follow_wall, new_q, new_b
):
    """Fill (new_q, new_b), a step ``h`` from (q, b) along its slope; return whether it is sound.

    To second order where ``back``, the step to the old state, is not zero. ``follow_wall`` puts nodes back
    that ran into the wall's curve. A prediction is sound that stays inside the wall and the rod, moves no
    node too far, and keeps every edge near its length and direction.
    """
    d = len(physics.axis)
    ratio = 0.0 if back == 0.0 else (h / back) ** 2
    for i in range(q.shape[0]):
        for k in range(len(physics.row)):
            change = h * slope[i, k]
            if ratio > 0:  # old = state + back slope + back^2 curve / 2
                change += ratio * (old_q[i, k] - q[i, k] - back * slope[i, k])
            new_q[i, k] = q[i, k] + change
    for k in range(b.size):
        change = h * slope_b[k]
        if ratio > 0:
            change += ratio * (old_b[k] - b[k] - back * slope_b[k])
        new_b[k] = b[k] + change
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
