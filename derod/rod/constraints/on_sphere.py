"""The menisci lie on the drop's surface (equa:AetBsphere, sys:meniscus-force).

    f_A (|x_A - x_C|^2 - 1/4) + f_B (|x_B - x_C|^2 - 1/4)

The multiplier f_A is the force with which the drop pulls the rod toward its centre.
"""

from __future__ import annotations

from derod.algebra.jit import inlined
from derod.rod.terms.wall import squared_distance
from derod.rod.unknowns import F_A, X_C


@inlined
def add_gradient(physics, kin, q, b, psi, tension, grad):
    """Add the forces f_A, f_B and both constraints."""
    d = len(physics.axis)
    for side in range(2):
        i = kin.node_a if side == 0 else kin.node_b
        force = b[F_A + d + side]
        for k in range(d):
            grad.node[i, k] += 2 * force * (q[i, k] - b[X_C + k])
        grad.border[F_A + d + side] += squared_distance(physics, q, b, i) - 0.25


@inlined
def add_hessian(physics, kin, q, b, psi, tension, hess):
    """Add 2 f on the menisci's nodes and the constraints' rows (those by x_i: ``rod.band``)."""
    d = len(physics.axis)
    for side in range(2):
        i = kin.node_a if side == 0 else kin.node_b
        row = F_A + d + side
        for k in range(d):
            hess.node[i, k, k] += 2 * b[row]
            slope = -2 * (q[i, k] - b[X_C + k])
            hess.border[row, X_C + k] += slope
            hess.border[X_C + k, row] += slope
