"""The half-rod equations at a point and at the stages of one collocation element.

State at a node, 10 numbers: w = r - r_C (3), q (4), n (3). The frame of eq:18d-equilibre is
carried by the unit quaternion q = (q_w, q_x, q_y, q_z), d_i = q e_i q*, so that d_3' = m x d_3
and d_1' = (m + (1 - k3) u3 d_3) x d_1 become

    q' = (m q + (1 - k3) u3 q e_3) / 2,      w' = d_3(q),      n' = chi grad v(w).

The moment is not integrated: c = m + w x n is conserved (the meniscus force is radial), c_y = 0
by the flip symmetry, u3 is uniform (equa_M3). Hence m = c - w x n with the four element
parameters (c_x, c_z, u3, sigma), sigma entering through the element's length. Gauss collocation
keeps |q| = 1. Two bending stiffnesses change q' alone (``section``).

In an element only the stage quaternions Q_k are unknowns: W_k and N_k follow from them explicitly.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from derod.branches.half_rod.gauss import MATRIX, STAGES
from derod.branches.half_rod.section import add_section_rate, anisotropic, local_twist

STATE = 10
PARAMETERS = 4  # c_x, c_z, u3, sigma
INPUTS = STATE + PARAMETERS
_M = STAGES
_A = MATRIX


@njit(cache=True, error_model="numpy")
def tangent(q, out):  # type: ignore[no-untyped-def]
    """d_3(q) into out (3,)."""
    out[0] = 2.0 * (q[1] * q[3] + q[0] * q[2])
    out[1] = 2.0 * (q[2] * q[3] - q[0] * q[1])
    out[2] = q[0] * q[0] - q[1] * q[1] - q[2] * q[2] + q[3] * q[3]


@njit(cache=True, error_model="numpy")
def tangent_derivative(q, out):  # type: ignore[no-untyped-def]
    """The derivative of d_3 with respect to q into out (3, 4)."""
    w, x, y, z = 2.0 * q[0], 2.0 * q[1], 2.0 * q[2], 2.0 * q[3]
    out[0, 0], out[0, 1], out[0, 2], out[0, 3] = y, z, w, x
    out[1, 0], out[1, 1], out[1, 2], out[1, 3] = -x, -w, z, y
    out[2, 0], out[2, 1], out[2, 2], out[2, 3] = w, -x, -y, z


@njit(cache=True, error_model="numpy")
def wall_gradient(w, strength, softness, grad, hess):  # type: ignore[no-untyped-def]
    """Gradient (3,) and Hessian (3, 3) of v = v0/(1 + rho - 2 |w|); returns the gap 1 + rho - 2
    |w|.

    The cone at w = 0 is met only in the limit: Gauss points never lie on a node.
    """
    r = np.sqrt(w[0] * w[0] + w[1] * w[1] + w[2] * w[2])
    gap = 1.0 + softness - 2.0 * r
    if r < 1e-200:
        r = 1e-200
    slope = 2.0 * strength / (gap * gap)
    across = slope / r
    along = 4.0 * slope / gap - across
    for i in range(3):
        grad[i] = across * w[i]
        for j in range(3):
            hess[i, j] = along * (w[i] / r) * (w[j] / r)
        hess[i, i] += across
    return gap


@njit(cache=True, error_model="numpy")
def moment(cx, cz, w, n, out):  # type: ignore[no-untyped-def]
    """m = c - w x n into out (3,)."""
    out[0] = cx - (w[1] * n[2] - w[2] * n[1])
    out[1] = -(w[2] * n[0] - w[0] * n[2])
    out[2] = cz - (w[0] * n[1] - w[1] * n[0])


@njit(cache=True, error_model="numpy")
def quaternion_rate(m, twist, q, out):  # type: ignore[no-untyped-def]
    """q' = (m q + twist q e_3)/2 into out (4,), twist = (1 - k3) u3."""
    out[0] = 0.5 * (-m[0] * q[1] - m[1] * q[2] - m[2] * q[3] - twist * q[3])
    out[1] = 0.5 * (m[0] * q[0] + m[1] * q[3] - m[2] * q[2] + twist * q[2])
    out[2] = 0.5 * (m[1] * q[0] + m[2] * q[1] - m[0] * q[3] - twist * q[1])
    out[3] = 0.5 * (m[2] * q[0] + m[0] * q[2] - m[1] * q[1] + twist * q[0])


@njit(cache=True, error_model="numpy")
def stages(y, Q, h, p, section, strength, softness, wet, D, W, G, H, N, Mm, P):  # type: ignore[no-untyped-def]
    """Stage tangents, places, wall forces, forces, moments and quaternion rates; returns the
    least gap."""
    gap = 1.0
    for k in range(_M):
        tangent(Q[k], D[k])
    for j in range(_M):
        for i in range(3):
            total = 0.0
            for k in range(_M):
                total += _A[j, k] * D[k, i]
            W[j, i] = y[i] + h * total
        if wet:
            gap = min(gap, wall_gradient(W[j], strength, softness, G[j], H[j]))
    for j in range(_M):
        for i in range(3):
            total = 0.0
            if wet:
                for k in range(_M):
                    total += _A[j, k] * G[k, i]
            N[j, i] = y[7 + i] + h * total
        moment(p[0], p[1], W[j], N[j], Mm[j])
        if anisotropic(section):
            quaternion_rate(Mm[j], local_twist(Mm[j], section, D[j]), Q[j], P[j])
            add_section_rate(Mm[j], section, Q[j], P[j])
        else:
            quaternion_rate(Mm[j], (1.0 - section[0]) * p[2], Q[j], P[j])
    return gap
