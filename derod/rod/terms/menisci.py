"""Capillarity, and the menisci's place on the sphere (equa:AetBsphere, sys:meniscus-force).

    - f_gamma (s_B - s_A) + f_A (|x_A - x_C|^2 - 1/4) + f_B (|x_B - x_C|^2 - 1/4)

The multiplier f_A is the force with which the drop pulls the rod toward its centre. Stationarity in
s_A and s_B is the tension jump (sys:tension-jump).

Sliding the drop along the rod costs nothing but exp(-sqrt(t) outer length), less than rounding. The
menisci are therefore pinned at mirror places, eta (s_A + s_B - l): eta is the force that this takes,
zero wherever the state is symmetric.
"""

from __future__ import annotations

from derod.algebra.jit import inlined
from derod.rod.layout import S_A, S_B, X_C
from derod.rod.terms.wall import squared_distance


@inlined
def capillary_energy(physics, b):
    """Return -f_gamma (s_B - s_A), K0/D."""
    return -physics.capillary_force * (b[S_B] - b[S_A])


@inlined
def add_menisci_gradient(physics, kin, q, b, grad):
    """Add f_gamma, the forces f_A, f_B and the three constraints."""
    d = len(physics.axis)
    grad.border[S_A] += physics.capillary_force + b[X_C + d + 2]
    grad.border[S_B] += -physics.capillary_force + b[X_C + d + 2]
    for side in range(2):
        i = kin.node_a if side == 0 else kin.node_b
        force = b[X_C + d + side]
        for k in range(d):
            grad.node[i, k] += 2 * force * (q[i, k] - b[X_C + k])
        grad.border[X_C + d + side] += squared_distance(physics, q, b, i) - 0.25
    grad.border[X_C + d + 2] += b[S_A] + b[S_B] - physics.length


@inlined
def add_menisci_hessian(physics, kin, q, b, hess):
    """Add 2 f on the menisci's nodes and the constraints' rows (those by x_i: ``assembly``)."""
    d = len(physics.axis)
    for side in range(2):
        i = kin.node_a if side == 0 else kin.node_b
        row = X_C + d + side
        for k in range(d):
            hess.node[i, k, k] += 2 * b[row]
            slope = -2 * (q[i, k] - b[X_C + k])
            hess.border[row, X_C + k] += slope
            hess.border[X_C + k, row] += slope
    for s in range(2):
        hess.border[s, X_C + d + 2] += 1.0
        hess.border[X_C + d + 2, s] += 1.0
