"""The factored Hessian: shifted, its unstable modes counted, solved with."""

from __future__ import annotations

from derod.algebra.bordered import factorize, solve_refined
from derod.algebra.copying import copy_vector
from derod.algebra.jit import kernel
from derod.rod.assembly import gradient, hessian
from derod.rod.unknowns import BORDER, F_A, MULTIPLIERS

FIRST_SHIFT = 1.0  # K0/D^4, of a soft mode's stiffness
LARGEST_SHIFT = 1e12
RAISE = 4.0
ANGLE_INERTIA = (
    0.01  # D^2: turning an edge about itself by an angle costs as moving it by a tenth of that
)


@kernel
def add_shift(physics, kin, linear, shift):
    """Add ``shift`` times the dual lengths to the nodes' diagonal, and to those of s_A, s_B, x_C."""
    d, w = len(physics.axis), len(physics.row)
    n = kin.rest.size - 2
    for i in range(1, n):
        dual = 0.5 * (kin.rest[i] + kin.rest[i + 1])
        for k in range(d):
            linear.band[w * (i - 1) + k, 0] += shift * dual
    if physics.slides:
        linear.band[w * (n - 1) + d - 1, 0] += shift * 0.5 * kin.rest[n]
    for e in range(1, n + 1):
        for k in range(d + 1, w):
            linear.band[w * (e - 1) + k, 0] += shift * ANGLE_INERTIA * kin.rest[e]
    for k in range(F_A + d):
        linear.corner[k, k] += shift


@kernel
def unstable_modes(physics, linear, factor):
    """Factor; return the negative eigenvalues beyond those that constraints and helper rows bring."""
    negative = factorize(linear, factor)
    if negative < 0:
        return -1
    n = (linear.band.shape[0] - linear.band.shape[1] + 1) // len(physics.row)
    return negative - n - MULTIPLIERS - (linear.corner.shape[0] - (BORDER + len(physics.axis)))


@kernel
def solve_step(physics, room, factor, work):
    """Fill the step (dq, db) that takes the residual to zero, with the factor at hand."""
    dq = work.dq
    d, w = len(physics.axis), len(physics.row)
    n = dq.shape[0] - 1
    x, y = factor.rhs, factor.rhs_border
    x[:] = 0.0
    y[:] = 0.0
    for i in range(1, n + 1):
        for k in range(w):
            if i < n or k >= d or (physics.slides and k == d - 1):
                x[w * (i - 1) + k] = -room.r[i, k]
    for k in range(BORDER + d):
        y[k] = -room.rb[k]
    solve_refined(room.linear, factor)
    dq[0] = 0.0
    for i in range(1, n + 1):
        for k in range(w):
            dq[i, k] = x[w * (i - 1) + k]
    copy_vector(y, work.db)


@kernel
def linearise(physics, mesh, psi, room, factor, q, b, shift):
    """Factor the Hessian at a state, shifted by ``shift`` times M; return its count of unstable modes."""
    gradient(physics, mesh, q, b, psi, room)
    hessian(physics, q, b, psi, room)
    add_shift(physics, room.kin, room.linear, shift)
    return unstable_modes(physics, room.linear, factor)
