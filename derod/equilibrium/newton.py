"""One implicit damped step: Newton's along a branch, or downhill.

    (H + shift M) dz = -residual

with M the dual lengths. *Following* a branch, the shift is zero and the state, stable or not, is trusted
only within a region round the one that was predicted. *Descending*, the shift is raised until the energy has
no direction of negative curvature left on the constraints, lengths are restored within the step, and it is
taken only if the energy on the constraints falls; the shift drops to zero where the energy is convex, and the
steps are Newton's there. Steps are limited by the gap to the wall (a barrier), by the rotation of an edge
and by the lengths of the three regions.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from derod.algebra.bordered import factorize, solve, solve_refined
from derod.algebra.copying import copy_rows, copy_vector
from derod.algebra.jit import inlined, kernel
from derod.rod.assembly import gradient, hessian, total_energy
from derod.rod.layout import S_A, S_B, X_C
from derod.rod.residual import EPS, excess
from derod.rod.terms.wall import stay_inside, wall_gap

FIRST_SHIFT = 1.0  # K0/D^4, of a soft mode's stiffness
LEAST_SHIFT = (
    1e-4  # where there is negative curvature, or a step fails: near a pitchfork it is small
)
LARGEST_SHIFT = 1e12
RAISE, LOWER, LOWER_CONVEX = 4.0, 0.2, 0.02
MOST_ROTATION = 0.5  # rad of an edge in one step, before and after lengths are restored
DESCENDING = (
    0.2  # rad, the same going downhill: longer steps leave the damped path, and end in other minima
)
MOST_GAP_USED = 0.7
MOST_REGION_USED = 0.5
TRIALS = 40
ENERGY_ROUNDING = 1e-13  # of f_gamma l, below which energies cannot tell two states apart
ARMIJO = 1e-4  # of the decrease that the slope promises, the least that a descending step must show
FALL = 0.1  # of the residual, the least share of what the step takes away that a followed step must show
HALVINGS = 4  # of a followed step
CORRECTIONS = 3  # of a followed trial's lengths, before it is condemned
RESTORATIONS = 12  # of a descending trial's lengths, at most
STRAIN = 1e-11  # relative, to which a descending step restores lengths
SHARP = 1 - np.cos(2.9)  # 1 - cos of a turning angle near pi: beyond it, another link begins
FARTHEST = 0.15  # D that a node may lie from where the branch was predicted
TURNED = 0.6  # rad that an edge may be turned from it
KICK_GAIN = (
    1 / 256
)  # of shift a^2: what a kick by a along a mode gains (the shift is up to 4 |eigenvalue|)

ACCEPTED, STALLED, STRAYED = 0, 1, 2  # what became of a step


class Rules(NamedTuple):
    """What a step must keep to."""

    tolerance: float  # K0/D^2, of the residual force
    descend: bool  # downhill, to a minimum; else along the branch
    kick: float  # D, the kick that would leave a saddle met on the way down


class Work(NamedTuple):
    """Arrays a step works in."""

    origin: np.ndarray  # (N+1, d+1) q as it was predicted
    dq: np.ndarray  # (N+1, d+1) the step
    db: np.ndarray  # (d+5,)
    tq: np.ndarray  # (N+1, d+1) the trial state
    tb: np.ndarray  # (d+5,)


def new_work(q: np.ndarray, b: np.ndarray) -> Work:
    """Return arrays for steps from the predicted state (q, b)."""
    return Work(q.copy(), np.zeros_like(q), np.zeros_like(b), np.zeros_like(q), np.zeros_like(b))


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
def constrained_energy(physics, q, b, psi, end_rotation, room, work, old_q, old_b):
    """Return the energy that the state has on the constraints, to second order in their violation.

    That is E_tot + lambda g with the multipliers after a full step. The gradient must have been taken.
    """
    d = len(physics.axis)
    energy = total_energy(physics, q, b, psi, end_rotation, room)
    for i in range(1, q.shape[0]):
        energy += (old_q[i, d] + work.dq[i, d]) * room.r[i, d]
    for k in range(X_C + d, d + 5):
        energy += (old_b[k] + work.db[k]) * room.rb[k]
    return energy


@inlined
def promised_decrease(work, room, d):
    """Return -dE along the step, to first order: the residual times the displacements."""
    fall = 0.0
    for i in range(1, work.dq.shape[0] - 1):
        for k in range(d):
            fall -= room.r[i, k] * work.dq[i, k]
    for k in range(X_C + d):
        fall -= room.rb[k] * work.db[k]
    return fall


@inlined
def strain(physics, room):
    """Return the largest violation of a constraint, in units of what a descending step may leave."""
    d = len(physics.axis)
    rounding = 8 * EPS * physics.length
    worst = 0.0
    for i in range(1, room.r.shape[0]):
        worst = max(worst, abs(room.r[i, d]) / (STRAIN * room.kin.rest[i] + rounding))
    for k in range(X_C + d, d + 5):
        worst = max(worst, abs(room.rb[k]) / (STRAIN + rounding))
    return worst


@inlined
def beyond(kin, q, origin, place, rotation):
    """Return whether a node is farther than ``place`` from ``origin``, or an edge turned by more.

    The tangents in ``kin`` are those of ``q``.
    """
    d = q.shape[1] - 1
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
    return False


@kernel
def is_restored(physics, room):
    """Return whether a state, its gradient taken, is on its constraints."""
    return strain(physics, room) <= 1


@inlined
def sharpest(kin):
    """Return the largest 1 - cos of a turning angle."""
    worst = 0.0
    for i in range(kin.fall.size):
        worst = max(worst, kin.fall[i])
    return worst


@inlined
def solve_lengths(room, factor, d, n):
    """Fill the correction that takes the constraints' violation to zero, with the factor at hand.

    A step along a curved, soft valley is tangent to the constraints and violates them to second order;
    charged with that, good steps would be refused (Maratos' effect).
    """
    x, y = factor.rhs, factor.rhs_border
    x[:] = 0.0
    y[:] = 0.0
    for i in range(1, n + 1):
        x[(d + 1) * (i - 1) + d] = -room.r[i, d]
    for k in range(X_C + d, d + 5):
        y[k] = -room.rb[k]
    solve(factor, x, y)


@kernel
def solve_step(room, factor, work):
    """Fill the step (dq, db) that takes the residual to zero, with the factor at hand."""
    dq = work.dq
    d = dq.shape[1] - 1
    n = dq.shape[0] - 1
    x, y = factor.rhs, factor.rhs_border
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
    copy_vector(y, work.db)


@inlined
def try_step(physics, kin, fraction, q, b, work):
    """Set the trial state a ``fraction`` of the step on, following the wall's curve."""
    for i in range(q.shape[0]):
        for k in range(q.shape[1]):
            work.tq[i, k] = q[i, k] + fraction * work.dq[i, k]
    for k in range(b.size):
        work.tb[k] = b[k] + fraction * work.db[k]
    stay_inside(physics, kin, q, b, work.tq, work.tb)


@inlined
def correct_lengths(physics, room, factor, q, b):
    """Restore lengths within the limits of a step; return the fraction of the correction that was taken."""
    d = q.shape[1] - 1
    n = q.shape[0] - 1
    x, y = factor.rhs, factor.rhs_border
    kin = room.kin
    fraction = 1.0
    for i in range(1, n + 1):
        square = 0.0
        for k in range(d):
            before = x[(d + 1) * (i - 2) + k] if i > 1 else 0.0
            square += (x[(d + 1) * (i - 1) + k] - before) ** 2
        fraction = min(fraction, MOST_ROTATION * kin.rest[i] / (np.sqrt(square) + 1e-300))
    for i in range(kin.node_a, kin.node_b + 1):
        r2, outward = 0.0, 0.0
        for k in range(d):
            place = q[i, k] - b[X_C + k]
            r2 += place * place
            outward += place * (x[(d + 1) * (i - 1) + k] - y[X_C + k])
        r = np.sqrt(r2) + 1e-300
        gap = 1 + physics.wall_softness - 2 * r
        if outward > 0:
            fraction = min(fraction, MOST_GAP_USED * gap * r / (2 * outward))
    for i in range(1, n + 1):
        for k in range(d + 1):
            q[i, k] += fraction * x[(d + 1) * (i - 1) + k]
    for k in range(d + 5):
        b[k] += fraction * y[k]
    return fraction


@kernel
def restore(physics, mesh, end_rotation, psi, room, factor, q, b):
    """Move a state onto its constraints with the factor at hand; return (psi, sound, strain left).

    A state is not sound that is not finite, leaves the wall, or whose lengths do not come right.
    """
    before, left = np.inf, np.inf
    for _ in range(RESTORATIONS):
        if not wall_gap(physics, room.kin, q, b) > 0:
            return psi, False, np.inf
        psi, sound = gradient(physics, mesh, q, b, psi, end_rotation, room)
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
        solve_lengths(room, factor, q.shape[1] - 1, q.shape[0] - 1)
        if (
            correct_lengths(physics, room, factor, q, b) < 1
        ):  # far off: the factor is not good for more
            before = np.inf
    return psi, False, left


@kernel
def follow_step(physics, mesh, end_rotation, rules, psi_old, room, factor, q, b, work):
    """Take one Newton step in place, shortened until the residual falls, within the region.

    Returns (outcome, psi, excess, force residual); ``room`` holds the gradient, on entry and on return.
    """
    d = len(physics.axis)
    old, force = excess(physics, room.r, room.rb, room.kin, rules.tolerance)
    sharp = max(SHARP, sharpest(room.kin))
    hessian(physics, q, b, psi_old, end_rotation, room)
    if factorize(room.linear, factor) < 0:
        return STALLED, psi_old, old, force
    solve_step(room, factor, work)
    fraction = longest_step(physics, room.kin, q, b, work.dq, work.db, MOST_ROTATION)
    outcome = STALLED
    for _ in range(HALVINGS):
        try_step(physics, room.kin, fraction, q, b, work)
        for correction in range(CORRECTIONS + 1):
            if not wall_gap(physics, room.kin, work.tq, work.tb) > 0:
                break
            psi, sound = gradient(physics, mesh, work.tq, work.tb, psi_old, end_rotation, room)
            if not sound or sharpest(room.kin) > sharp:
                break
            new, new_force = excess(physics, room.r, room.rb, room.kin, rules.tolerance)
            if new < (1 - FALL * fraction) * old or new <= 1:
                if beyond(room.kin, work.tq, work.origin, FARTHEST, TURNED):
                    outcome = STRAYED
                    break
                copy_rows(work.tq, q)
                copy_vector(work.tb, b)
                return ACCEPTED, psi, new, new_force
            if correction < CORRECTIONS:
                solve_lengths(room, factor, d, q.shape[0] - 1)
                correct_lengths(physics, room, factor, work.tq, work.tb)
        if outcome == STRAYED:
            break
        fraction *= 0.5
    gradient(physics, mesh, q, b, psi_old, end_rotation, room)
    return outcome, psi_old, old, force


@kernel
def descend_step(physics, mesh, end_rotation, rules, shift, psi_old, room, factor, q, b, work):
    """Take one downhill step in place, from a state on its constraints to another.

    The energy on the constraints falls, beyond rounding it never rises. Returns (outcome, shift to go on
    with, psi, excess, force residual, whether the energy had a direction of negative curvature, and whether a
    kick along it would gain more than the step); ``room`` holds the gradient, on entry and on return.
    """
    d = len(physics.axis)
    old, force = excess(physics, room.r, room.rb, room.kin, rules.tolerance)
    sharp = max(SHARP, sharpest(room.kin))
    slack = ENERGY_ROUNDING * (1 + physics.capillary_force) * physics.length
    curved = False
    for trial in range(TRIALS):
        hessian(physics, q, b, psi_old, end_rotation, room)
        modes = unstable_modes(room.linear, factor, d)
        if trial == 0:
            curved = modes != 0
        if modes != 0:
            shift = max(shift, LEAST_SHIFT)
        if shift > 0:
            add_shift(room.kin, room.linear, d, shift)
            modes = unstable_modes(room.linear, factor, d)
        while modes != 0 and shift < LARGEST_SHIFT:
            add_shift(room.kin, room.linear, d, (RAISE - 1) * shift)
            shift *= RAISE
            modes = unstable_modes(room.linear, factor, d)
        solve_step(room, factor, work)
        fraction = longest_step(physics, room.kin, q, b, work.dq, work.db, DESCENDING)
        fall = fraction * promised_decrease(work, room, d)
        before = constrained_energy(physics, q, b, psi_old, end_rotation, room, work, q, b)
        try_step(physics, room.kin, fraction, q, b, work)
        psi, sound, _ = restore(
            physics, mesh, end_rotation, psi_old, room, factor, work.tq, work.tb
        )
        sound = sound and sharpest(room.kin) <= sharp
        if sound and not beyond(room.kin, work.tq, q, np.inf, 1.2 * DESCENDING):
            new, new_force = excess(physics, room.r, room.rb, room.kin, rules.tolerance)
            after = constrained_energy(
                physics, work.tq, work.tb, psi, end_rotation, room, work, q, b
            )
            if fall > 10 * slack:
                lower = after <= before - ARMIJO * fall
            else:  # energies cannot tell any more; off a saddle the residual grows at first
                lower = after <= before + slack and (new < old or curved)
            if lower:
                copy_rows(work.tq, q)
                copy_vector(work.tb, b)
                saddle = curved and fall < KICK_GAIN * shift * rules.kick**2
                if fraction == 1.0:
                    shift *= LOWER if curved else LOWER_CONVEX
                    if shift < LEAST_SHIFT:
                        shift = 0.0
                return ACCEPTED, shift, psi, new, new_force, curved, saddle
        shift = max(LEAST_SHIFT, RAISE * shift)
        gradient(physics, mesh, q, b, psi_old, end_rotation, room)
        if shift > LARGEST_SHIFT:
            break
    return STALLED, shift, psi_old, old, force, curved, curved


@kernel
def linearise(physics, mesh, end_rotation, psi, room, factor, q, b, shift):
    """Factor the Hessian at a state, shifted by ``shift`` times M; return its count of unstable modes."""
    gradient(physics, mesh, q, b, psi, end_rotation, room)
    hessian(physics, q, b, psi, end_rotation, room)
    add_shift(room.kin, room.linear, len(physics.axis), shift)
    return unstable_modes(room.linear, factor, len(physics.axis))
