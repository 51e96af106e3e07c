"""How far one step may go: by the turn of an edge, the wall's gap, the lengths of the three regions."""

from __future__ import annotations

import numpy as np

from derod.algebra.jit import inlined
from derod.rod.terms.wall import stay_inside
from derod.rod.unknowns import S_A, S_B, X_C

MOST_ROTATION = 0.5  # rad of an edge in one step, before and after lengths are restored
MOST_GAP_USED = 0.7
MOST_REGION_USED = 0.5
SHARP = 1 - np.cos(2.9)  # 1 - cos of a turning angle near pi: beyond it, another link begins


@inlined
def longest_step(physics, kin, q, b, dq, db, rotation):
    """Return the fraction of the step (dq, db) that stays inside the limits, at most 1.

    No edge may turn by more than ``rotation`` (rad).
    """
    d = len(physics.axis)
    n = kin.rest.size - 2
    fraction = 1.0
    for e in range(1, n + 1):
        square = 0.0
        for k in range(d):
            square += (dq[e, k] - dq[e - 1, k]) ** 2
        fraction = min(fraction, rotation * kin.rest[e] / (np.sqrt(square) + 1e-300))
        for k in range(d + 1, len(physics.row)):
            fraction = min(fraction, rotation / (abs(dq[e, k]) + 1e-300))
    for i in range(kin.node_a, kin.node_b + 1):
        r2 = 0.0
        outward = 0.0
        for k in range(d):
            x = q[i, k] - b[X_C + k]
            r2 += x * x
            outward += x * (dq[i, k] - db[X_C + k])
        r = np.sqrt(r2) + 1e-300
        gap = 1 + physics.wall_softness - 2 * r
        outward *= 2 / r
        if outward > 0:
            fraction = min(fraction, MOST_GAP_USED * gap / outward)
    wetted = b[S_B] - b[S_A]
    for region, change in (
        (b[S_A], -db[S_A]),
        (wetted, db[S_A] - db[S_B]),
        (physics.length - b[S_B], db[S_B]),
    ):
        if change > 0:
            fraction = min(fraction, MOST_REGION_USED * region / change)
    return fraction


@inlined
def beyond(physics, kin, q, origin, place, rotation):
    """Return whether a node is farther than ``place`` from ``origin``, or an edge turned by more.

    The tangents in ``kin`` are those of ``q``.
    """
    d = len(physics.axis)
    least = np.cos(rotation)
    for i in range(1, q.shape[0]):
        far, along, square = 0.0, 0.0, 0.0
        for k in range(d):
            far += (q[i, k] - origin[i, k]) ** 2
            edge = origin[i, k] - origin[i - 1, k]
            along += kin.tangent[k, i] * edge
            square += edge * edge
        if not (far <= place * place and along >= least * np.sqrt(square)):
            return True
        for k in range(d + 1, len(physics.row)):
            if not abs(q[i, k] - origin[i, k]) <= rotation:
                return True
    return False


@inlined
def sharpest(kin):
    """Return the largest 1 - cos of a turning angle."""
    worst = 0.0
    for i in range(kin.fall.size):
        worst = max(worst, kin.fall[i])
    return worst


@inlined
def try_step(physics, kin, fraction, q, b, work):
    """Set the trial state a ``fraction`` of the step on, following the wall's curve."""
    for i in range(q.shape[0]):
        for k in range(q.shape[1]):
            work.tq[i, k] = q[i, k] + fraction * work.dq[i, k]
    for k in range(b.size):
        work.tb[k] = b[k] + fraction * work.db[k]
    stay_inside(physics, kin, q, b, work.tq, work.tb)
