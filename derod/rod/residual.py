"""How far a residual is above what is asked for, and above what rounding leaves.

A force on node i is a difference of bending forces of size 1/h^2 taken between positions known to
eps l, so it cannot fall below about eps l / h^3; nor, beside a hard wall, below eps l times the wall's
stiffness 8 v0 / gap^3. The tolerance of a row is the asked one plus that.
"""

from __future__ import annotations

import numpy as np

from derod.algebra.jit import kernel
from derod.rod.unknowns import BORDER, F_A

EPS = float(np.finfo(np.float64).eps)
ROUNDING = 16.0  # of the stiffness h^-3 of a bent vertex, of K2 h^-3 where that is harder to bend
WALL_ROUNDING = 2.0  # of the wall's


@kernel
def excess(physics, r, rb, kin, tolerance):
    """Return (largest ratio of a residual to its tolerance, largest force residual in K0/D^2).

    Forces are held to ``tolerance`` (K0/D^2), moments about edges too (K0/D), lengths to ``tolerance``
    (relative); at most 1 is converged. The ends' rows are reactions and are left out, but for the axial
    one of an end that slides.
    """
    d = len(physics.axis)
    n = r.shape[0] - 1
    worst = 0.0
    force = 0.0
    rounding = ROUNDING * max(1.0, 1 + physics.stiffening, physics.torsion)
    if physics.slides:
        force = abs(r[n, d - 1])
        h = kin.rest[n]
        worst = force / (tolerance + EPS * physics.length * rounding / (h * h * h))
    barrier = 0.0
    shortest = kin.rest[1]
    for i in range(1, n + 1):
        shortest = min(shortest, kin.rest[i])
        length = tolerance * kin.rest[i] + 8 * EPS * physics.length
        worst = max(worst, abs(r[i, d]) / length)
        if i == n:
            continue
        h = min(kin.rest[i], kin.rest[i + 1])
        stiffness = rounding / (h * h * h) + WALL_ROUNDING * kin.barrier[i]
        allowed = tolerance + EPS * physics.length * stiffness
        barrier += kin.barrier[i] ** 2
        for k in range(d):
            force = max(force, abs(r[i, k]))
            worst = max(worst, abs(r[i, k]) / allowed)
    stiffness = rounding / (shortest * shortest) + WALL_ROUNDING * np.sqrt(barrier)
    allowed = tolerance + EPS * physics.length * stiffness
    for e in range(1, n + 1):
        for k in range(d + 1, len(physics.row)):
            moment = tolerance + EPS * rounding * physics.length / (kin.rest[e] * kin.rest[e])
            worst = max(worst, abs(r[e, k]) / moment)
    for k in range(F_A + d):
        force = max(force, abs(rb[k]))
        worst = max(worst, abs(rb[k]) / allowed)
    for k in range(F_A + d, BORDER + d):
        worst = max(worst, abs(rb[k]) / (tolerance + 8 * EPS * physics.length))
    return worst, force
