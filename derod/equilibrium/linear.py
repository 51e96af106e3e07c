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


@kernel
def add_shift(physics, kin, linear, shift):
    """Add ``shift`` times the dual lengths to the nodes' diagonal, and to those of s_A, s_B, x_C."""
    d = len(physics.axis)
    n = kin.rest.size - 2
    for i in range(1, n):
        dual = 0.5 * (kin.rest[i] + kin.rest[i + 1])
        for k in range(d):
            linear.band[(d + 1) * (i - 1) + k, 0] += shift * dual
    if physics.slides:
        linear.band[(d + 1) * (n - 1) + d - 1, 0] += shift * 0.5 * kin.rest[n]
    for k in range(F_A + d):
        linear.corner[k, k] += shift


@kernel
def unstable_modes(linear, factor, d):
    """Factor; return the negative eigenvalues beyond those that constraints and helper rows bring."""
    negative = factorize(linear, factor)
    if negative < 0:
        return -1
    n = (linear.band.shape[0] - linear.band.shape[1] + 1) // (d + 1)
    return negative - n - MULTIPLIERS - (linear.corner.shape[0] - (BORDER + d))


@kernel
def solve_step(physics, room, factor, work):
    """Fill the step (dq, db) that takes the residual to zero, with the factor at hand."""
    dq = work.dq
    d = dq.shape[1] - 1
    n = dq.shape[0] - 1
    x, y = factor.rhs, factor.rhs_border
    x[:] = 0.0
    y[:] = 0.0
    for i in range(1, n + 1):
        for k in range(d + 1):
            if i < n or k == d or (physics.slides and k == d - 1):
                x[(d + 1) * (i - 1) + k] = -room.r[i, k]
    for k in range(BORDER + d):
        y[k] = -room.rb[k]
    solve_refined(room.linear, factor)
    dq[0] = 0.0
    for i in range(1, n + 1):
        for k in range(d + 1):
            dq[i, k] = x[(d + 1) * (i - 1) + k]
    copy_vector(y, work.db)


@kernel
def linearise(physics, mesh, psi, room, factor, q, b, shift):
    """Factor the Hessian at a state, shifted by ``shift`` times M; return its count of unstable modes."""
    gradient(physics, mesh, q, b, psi, room)
    hessian(physics, q, b, psi, room)
    add_shift(physics, room.kin, room.linear, shift)
    return unstable_modes(room.linear, factor, len(physics.axis))
