"""Put a state back onto its constraints, with the factor of the Hessian at hand."""

from __future__ import annotations

import numpy as np

from derod.algebra.bordered import solve
from derod.algebra.jit import inlined, kernel
from derod.equilibrium.limits import MOST_GAP_USED, MOST_ROTATION
from derod.rod.assembly import gradient
from derod.rod.residual import EPS
from derod.rod.terms.wall import wall_gap
from derod.rod.unknowns import BORDER, F_A, X_C

RESTORATIONS = 12  # of a descending trial's lengths, at most
STRAIN = 1e-11  # relative, to which a descending step restores lengths


@inlined
def strain(physics, room):
    """Return the largest violation of a constraint, in units of what a descending step may leave."""
    d = len(physics.axis)
    rounding = 8 * EPS * physics.length
    worst = 0.0
    for i in range(1, room.r.shape[0]):
        worst = max(worst, abs(room.r[i, d]) / (STRAIN * room.kin.rest[i] + rounding))
    for k in range(F_A + d, BORDER + d):
        worst = max(worst, abs(room.rb[k]) / (STRAIN + rounding))
    return worst


@kernel
def is_restored(physics, room):
    """Return whether a state, its gradient taken, is on its constraints."""
    return strain(physics, room) <= 1


@inlined
def solve_lengths(physics, room, factor):
    """Fill the correction that takes the constraints' violation to zero, with the factor at hand.

    A step along a curved, soft valley is tangent to the constraints and violates them to second order;
    charged with that, good steps would be refused (Maratos' effect).
    """
    d, w = len(physics.axis), len(physics.row)
    x, y = factor.rhs, factor.rhs_border
    x[:] = 0.0
    y[:] = 0.0
    for i in range(1, room.r.shape[0]):
        x[w * (i - 1) + d] = -room.r[i, d]
    for k in range(F_A + d, BORDER + d):
        y[k] = -room.rb[k]
    solve(factor, x, y)


@inlined
def correct_lengths(physics, room, factor, q, b):
    """Restore lengths within the limits of a step; return the fraction of the correction that was taken."""
    d, w = len(physics.axis), len(physics.row)
    n = q.shape[0] - 1
    x, y = factor.rhs, factor.rhs_border
    kin = room.kin
    fraction = 1.0
    for i in range(1, n + 1):
        square = 0.0
        for k in range(d):
            before = x[w * (i - 2) + k] if i > 1 else 0.0
            square += (x[w * (i - 1) + k] - before) ** 2
        fraction = min(fraction, MOST_ROTATION * kin.rest[i] / (np.sqrt(square) + 1e-300))
    for i in range(kin.node_a, kin.node_b + 1):
        r2, outward = 0.0, 0.0
        for k in range(d):
            place = q[i, k] - b[X_C + k]
            r2 += place * place
            outward += place * (x[w * (i - 1) + k] - y[X_C + k])
        r = np.sqrt(r2) + 1e-300
        gap = 1 + physics.wall_softness - 2 * r
        if outward > 0:
            fraction = min(fraction, MOST_GAP_USED * gap * r / (2 * outward))
    for i in range(1, n + 1):
        for k in range(w):
            q[i, k] += fraction * x[w * (i - 1) + k]
    for k in range(BORDER + d):
        b[k] += fraction * y[k]
    return fraction


@kernel
def restore(physics, mesh, psi, room, factor, q, b):
    """Move a state onto its constraints with the factor at hand; return (psi, sound, strain left).

    A state is not sound that is not finite, leaves the wall, or whose lengths do not come right.
    """
    before, left = np.inf, np.inf
    for _ in range(RESTORATIONS):
        if not wall_gap(physics, room.kin, q, b) > 0:
            return psi, False, np.inf
        psi, sound = gradient(physics, mesh, q, b, psi, room)
        if not sound:
            return psi, False, np.inf
        left = strain(physics, room)
        if left <= 1 or (
            left < 100 and left > 0.5 * before
        ):  # restored, or as far as rounding lets
            return psi, True, left
        if left > 0.9 * before:
            return psi, False, left
        before = left
        solve_lengths(physics, room, factor)
        if (
            correct_lengths(physics, room, factor, q, b) < 1
        ):  # far off: the factor is not good for more
            before = np.inf
    return psi, False, left
