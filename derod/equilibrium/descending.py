"""One implicit step downhill, from state to state on the constraints.

    (H + shift M) dz = -residual

with M the dual lengths. The shift is raised until the energy has no direction of negative curvature left on
the constraints, lengths are restored within the step, and it is taken only if the energy there falls; the
shift drops to zero where the energy is convex, and the steps are Newton's there.
"""

from __future__ import annotations

import numpy as np

from derod.algebra.copying import copy_rows, copy_vector
from derod.algebra.jit import inlined, kernel
from derod.equilibrium.lengths import restore
from derod.equilibrium.limits import SHARP, beyond, longest_step, sharpest, try_step
from derod.equilibrium.linear import LARGEST_SHIFT, RAISE, add_shift, solve_step, unstable_modes
from derod.equilibrium.steps import ACCEPTED, STALLED
from derod.rod.assembly import gradient, hessian, potential
from derod.rod.residual import excess
from derod.rod.unknowns import BORDER, F_A

LEAST_SHIFT = (
    1e-4  # where there is negative curvature, or a step fails: near a pitchfork it is small
)
LOWER, LOWER_CONVEX = 0.2, 0.02
DESCENDING = (
    0.2  # rad, the same going downhill: longer steps leave the damped path, and end in other minima
)
TRIALS = 40
ENERGY_ROUNDING = 1e-13  # of f_gamma l, below which energies cannot tell two states apart
ARMIJO = 1e-4  # of the decrease that the slope promises, the least that a descending step must show
KICK_GAIN = (
    1 / 256
)  # of shift a^2: what a kick by a along a mode gains (the shift is up to 4 |eigenvalue|)


@inlined
def constrained_energy(physics, q, b, psi, room, work, old_q, old_b):
    """Return the energy that the state has on the constraints, to second order in their violation.

    That is E_tot + lambda g with the multipliers after a full step. The gradient must have been taken.
    """
    d = len(physics.axis)
    energy = potential(physics, q, b, psi, room)
    for i in range(1, q.shape[0]):
        energy += (old_q[i, d] + work.dq[i, d]) * room.r[i, d]
    for k in range(F_A + d, BORDER + d):
        energy += (old_b[k] + work.db[k]) * room.rb[k]
    return energy


@inlined
def promised_decrease(physics, work, room):
    """Return -dE along the step, to first order: the residual times the displacements."""
    d = len(physics.axis)
    fall = 0.0
    if physics.slides:
        end = work.dq.shape[0] - 1
        fall -= room.r[end, d - 1] * work.dq[end, d - 1]
    for i in range(1, work.dq.shape[0] - 1):
        for k in range(d):
            fall -= room.r[i, k] * work.dq[i, k]
    for e in range(1, work.dq.shape[0]):
        for k in range(d + 1, len(physics.row)):
            fall -= room.r[e, k] * work.dq[e, k]
    for k in range(F_A + d):
        fall -= room.rb[k] * work.db[k]
    return fall


@kernel
def descend_step(physics, mesh, rules, shift, psi_old, room, factor, q, b, work):
    """Take one downhill step in place, from a state on its constraints to another.

    The energy on the constraints falls, beyond rounding it never rises. Returns (outcome, shift to go on
    with, psi, excess, force residual, whether the energy had a direction of negative curvature, and whether a
    kick along it would gain more than the step); ``room`` holds the gradient, on entry and on return.
    """
    old, force = excess(physics, room.r, room.rb, room.kin, rules.tolerance)
    sharp = max(SHARP, sharpest(room.kin))
    slack = ENERGY_ROUNDING * (1 + physics.capillary_force) * physics.length
    curved = False
    for trial in range(TRIALS):
        hessian(physics, q, b, psi_old, room)
        modes = unstable_modes(physics, room.linear, factor)
        if trial == 0:
            curved = modes != 0
        if modes != 0:
            shift = max(shift, LEAST_SHIFT)
        if shift > 0:
            add_shift(physics, room.kin, room.linear, shift)
            modes = unstable_modes(physics, room.linear, factor)
        while modes != 0 and shift < LARGEST_SHIFT:
            add_shift(physics, room.kin, room.linear, (RAISE - 1) * shift)
            shift *= RAISE
            modes = unstable_modes(physics, room.linear, factor)
        solve_step(physics, room, factor, work, True)
        fraction = longest_step(physics, room.kin, q, b, work.dq, work.db, DESCENDING)
        fall = fraction * promised_decrease(physics, work, room)
        before = constrained_energy(physics, q, b, psi_old, room, work, q, b)
        try_step(physics, room.kin, fraction, q, b, work)
        psi, sound, _ = restore(physics, mesh, psi_old, room, factor, work.tq, work.tb)
        sound = sound and sharpest(room.kin) <= sharp
        if sound and not beyond(physics, room.kin, work.tq, q, np.inf, 1.2 * DESCENDING):
            new, new_force = excess(physics, room.r, room.rb, room.kin, rules.tolerance)
            after = constrained_energy(physics, work.tq, work.tb, psi, room, work, q, b)
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
        gradient(physics, mesh, q, b, psi_old, room)
        if shift > LARGEST_SHIFT:
            break
    return STALLED, shift, psi_old, old, force, curved, curved
