"""One implicit damped step: pseudo-transient far from equilibrium, Newton near it.

    (H + shift M) dz = -residual

with M the dual lengths. Where a plain Newton step fails, or where only descent is wanted, the shift is
raised until the energy has no direction of negative curvature left on the constraints: a step is then
downhill. It falls to zero on approach, and the steps converge quadratically. Steps are limited by the
gap to the wall (a barrier), by the rotation of an edge and by the lengths of the three regions.
"""

from __future__ import annotations

import numpy as np

from derod.core.assembly import energies, gradient, hessian
from derod.core.copying import copy_rows, copy_vector
from derod.core.jit import inlined, kernel
from derod.core.layout import S_A, S_B, X_C
from derod.core.residual import excess
from derod.core.wall import stay_inside, wall_gap
from derod.linalg.bordered import factorize, solve, solve_refined

FIRST_SHIFT = 1.0  # K0/D^4, of a soft mode's stiffness; where a step fails
LEAST_SHIFT = 1e-4  # where there is negative curvature: near a pitchfork it is small
LARGEST_SHIFT = 1e12
RAISE, LOWER = 8.0, 0.2
MOST_ROTATION = 0.5  # rad of an edge in one step
MOST_GAP_USED = 0.7
MOST_REGION_USED = 0.5
TRIALS = 40
ENERGY_ROUNDING = 1e-13  # of f_gamma l, below which energies cannot tell two states apart
CORRECTIONS = 3  # of a trial's lengths, before its merit condemns it


@kernel
def add_shift(kin, linear, d, shift):
    """Add ``shift`` times the dual lengths to the nodes' diagonal, and to those of s_A, s_B, x_C."""
    n = kin.rest.size - 2
    for i in range(1, n):
        dual = 0.5 * (kin.rest[i] + kin.rest[i + 1])
        for k in range(d):
            linear.band[(d + 1) * (i - 1) + k, 0] += shift * dual
    for k in range(X_C + d):
        linear.corner[k, k] += shift


@kernel
def unstable_modes(linear, factor, d):
    """Factor; return the negative eigenvalues beyond those that constraints and helper rows bring."""
    negative = factorize(linear, factor)
    if negative < 0:
        return -1
    n = (linear.band.shape[0] - linear.band.shape[1] + 1) // (d + 1)
    return negative - n - 3 - (linear.corner.shape[0] - d - 5)


@inlined
def longest_step(physics, kin, q, b, dq, db):
    """Return the fraction of the step (dq, db) that stays inside the limits, at most 1."""
    d = len(physics.axis)
    n = kin.rest.size - 2
    fraction = 1.0
    for e in range(1, n + 1):
        square = 0.0
        for k in range(d):
            square += (dq[e, k] - dq[e - 1, k]) ** 2
        fraction = min(fraction, MOST_ROTATION * kin.rest[e] / (np.sqrt(square) + 1e-300))
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


@kernel
def merit(physics, q, b, psi, end_rotation, penalty, room):
    """Return E_tot plus ``penalty`` times the violated constraints (exact for a large penalty)."""
    d = len(physics.axis)
    e = energies(physics, q, b, psi, end_rotation, room)
    violation = 0.0
    for i in range(1, q.shape[0]):
        violation += abs(room.r[i, d])
    for k in range(X_C + d, d + 5):
        violation += abs(room.rb[k])
    return e[0] + e[1] + e[2] + e[3] + penalty * violation


@inlined
def largest_multiplier(q, b, dq, db, d):
    """Return the largest multiplier before or after a full step, K0/D^2."""
    largest = 0.0
    for i in range(1, q.shape[0]):
        largest = max(largest, abs(q[i, d]), abs(q[i, d] + dq[i, d]))
    for k in range(X_C + d, d + 5):
        largest = max(largest, abs(b[k]), abs(b[k] + db[k]))
    return largest


@inlined
def restore_lengths(room, factor, tq, tb):
    """Move a trial state back toward its constraints, with the factor at hand.

    A step along a curved, soft valley is tangent to the constraints and violates them to second order;
    charged with that, good steps would be refused (Maratos' effect).
    """
    d = tq.shape[1] - 1
    n = tq.shape[0] - 1
    x, y = factor.rhs, factor.rhs_border
    x[:] = 0.0
    y[:] = 0.0
    for i in range(1, n + 1):
        x[(d + 1) * (i - 1) + d] = -room.r[i, d]
    for k in range(X_C + d, d + 5):
        y[k] = -room.rb[k]
    solve(factor, x, y)
    for i in range(1, n + 1):
        for k in range(d + 1):
            tq[i, k] += x[(d + 1) * (i - 1) + k]
    for k in range(d + 5):
        tb[k] += y[k]


@kernel
def newton_step(
    physics, mesh, end_rotation, tolerance, descend, shift, psi, room, factor, q, b, dq, db, tq, tb
):
    """Improve the state (q, b, psi) in place by one damped step.

    With ``descend`` every step is downhill. Without, plain Newton steps are taken as long as they make
    progress, toward whatever equilibrium the state was predicted for, stable or not.

    ``room`` holds the gradient at the state, on entry and on return. ``dq, db, tq, tb`` are room for
    the step and the trial state.
    Returns (accepted, shift to go on with, psi, excess, force residual).
    """
    d = len(physics.axis)
    n = room.kin.rest.size - 2
    old, force = excess(physics, room.r, room.rb, room.kin, tolerance)
    psi_old = psi
    x = factor.rhs
    y = factor.rhs_border
    for _ in range(TRIALS):
        hessian(physics, q, b, psi_old, end_rotation, room)
        add_shift(room.kin, room.linear, d, shift)
        modes = unstable_modes(room.linear, factor, d)
        while (modes < 0 or (modes > 0 and (descend or shift > 0))) and shift < LARGEST_SHIFT:
            more = max(LEAST_SHIFT, (RAISE - 1) * shift)
            add_shift(room.kin, room.linear, d, more)
            shift += more
            modes = unstable_modes(room.linear, factor, d)
        x[:] = 0.0
        y[:] = 0.0
        for i in range(1, n + 1):
            for k in range(d + 1):
                if i < n or k == d:
                    x[(d + 1) * (i - 1) + k] = -room.r[i, k]
        for k in range(d + 5):
            y[k] = -room.rb[k]
        solve_refined(room.linear, factor)
        dq[0] = 0.0
        for i in range(1, n + 1):
            for k in range(d + 1):
                dq[i, k] = x[(d + 1) * (i - 1) + k]
        copy_vector(y, db)
        fraction = longest_step(physics, room.kin, q, b, dq, db)
        penalty = 1 + 1.5 * largest_multiplier(q, b, dq, db, d)
        before = merit(physics, q, b, psi_old, end_rotation, penalty, room)
        for i in range(n + 1):
            for k in range(d + 1):
                tq[i, k] = q[i, k] + fraction * dq[i, k]
        for k in range(d + 5):
            tb[k] = b[k] + fraction * db[k]
        stay_inside(physics, room.kin, q, b, tq, tb)
        for correction in range(CORRECTIONS + 1):
            if wall_gap(physics, room.kin, tq, tb) <= 0:
                break
            psi, sound = gradient(physics, mesh, tq, tb, psi_old, end_rotation, room)
            if not sound:
                break
            new, new_force = excess(physics, room.r, room.rb, room.kin, tolerance)
            after = merit(physics, tq, tb, psi, end_rotation, penalty, room)
            slack = ENERGY_ROUNDING * physics.capillary_force * physics.length
            if new < 0.9 * old or after < before or (new < old and after < before + slack):
                copy_rows(tq, q)
                copy_vector(tb, b)
                if fraction == 1.0:
                    shift *= LOWER
                    if shift < LEAST_SHIFT:
                        shift = 0.0
                return True, shift, psi, new, new_force
            if correction < CORRECTIONS:
                restore_lengths(room, factor, tq, tb)
        shift = max(FIRST_SHIFT, RAISE * shift)
        if shift > LARGEST_SHIFT:
            break
        gradient(physics, mesh, q, b, psi_old, end_rotation, room)
    gradient(physics, mesh, q, b, psi_old, end_rotation, room)
    return False, shift, psi_old, old, force


@kernel
def linearise(physics, mesh, end_rotation, psi, room, factor, q, b, shift):
    """Factor the Hessian at a state, shifted by ``shift`` times M; return its count of unstable modes."""
    gradient(physics, mesh, q, b, psi, end_rotation, room)
    hessian(physics, q, b, psi, end_rotation, room)
    add_shift(room.kin, room.linear, len(physics.axis), shift)
    return unstable_modes(room.linear, factor, len(physics.axis))
