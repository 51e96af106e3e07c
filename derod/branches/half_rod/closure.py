"""The conditions at the rod's middle, at the meniscus and at the clamp, and the jump there.

Unknowns kept after the elimination, 37: U = (Y(0), Y(sigma-), Y(l/2), c_x, c_z, u3, sigma, delta,
f_gamma, W). Rows, 14: eq:initcond (x, z, q_x, q_z, n_y = 0; |q| = 1; u3 from the moment), eq:bcnd-end
(meniscus on the sphere; n_y = W/2 *after* the jump) and the clamp (x, z, q_x, q_y, end rotation).

Weight: equa:saut_global, n^III - n^I + W = 0 with the vector W = (0, -W, 0), and n_y odd under the
flip: n_y^III = -n_y^I = W/2. Each clamp carries half of the drop. The weight acts on the drop and
not on the rod: n is continuous at the rod's middle, n_y(0) = 0, and c = m + w x n keeps c_y = 0.
The printed d_1y(l/2) = 0 leaves the turn open; q(l/2) turned by R/2 about e_z,
cos(R/4) q_z = sin(R/4) q_w, fixes it modulo 4 pi.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from derod.branches.half_rod.element import moment, tangent, tangent_derivative

KEPT = 37
ROWS = 14
NODE_0, NODE_SIGMA, NODE_END = 0, 10, 20
CX, CZ, U3, SIGMA, DELTA, FGAMMA, WEIGHT = 30, 31, 32, 33, 34, 35, 36

# row numbers
(
    MIDDLE_X,
    MIDDLE_Z,
    MIDDLE_QX,
    MIDDLE_QZ,
    MIDDLE_NY,
    UNIT,
    TWIST,
    SPHERE,
    SIDEWAYS,
    CLAMP_X,
    CLAMP_Z,
    CLAMP_QX,
    CLAMP_QY,
    CLAMP_TURN,
) = range(14)


@njit(cache=True, error_model="numpy")
def jump(y, capillary, wall, out, jacobian):  # type: ignore[no-untyped-def]
    """State after the meniscus: n+ = n- + (f_gamma - v) w / (w . d_3), i.e. 2 f_B w with
    eq:bcnd-end's f_B.

    Writes out (10,) and jacobian (10, 11): with respect to y, then f_gamma. Returns f_B. v(sigma)
    = v0/rho is ``wall``.
    """
    t = np.empty(3)
    E = np.empty((3, 4))
    tangent(y[3:7], t)
    tangent_derivative(y[3:7], E)
    across = y[0] * t[0] + y[1] * t[1] + y[2] * t[2]
    f = (capillary - wall) / across
    jacobian[:] = 0.0
    for i in range(10):
        out[i] = y[i]
        jacobian[i, i] = 1.0
    for i in range(3):
        out[7 + i] += f * y[i]
        jacobian[7 + i, i] += f
        jacobian[7 + i, 10] = y[i] / across
        for j in range(3):
            jacobian[7 + i, j] -= f * y[i] * t[j] / across
        for j in range(4):
            total = y[0] * E[0, j] + y[1] * E[1, j] + y[2] * E[2, j]
            jacobian[7 + i, 3 + j] -= f * y[i] * total / across
    return 0.5 * f


@njit(cache=True, error_model="numpy")
def conditions(U, half, k3, rotation, after, jacobian, F, J):  # type: ignore[no-untyped-def]
    """Residuals F (14,) and their derivatives J (14, 37); ``after``, ``jacobian`` from ``jump``."""
    J[:] = 0.0
    y, s, e = U[0:10], U[10:20], U[20:30]
    F[MIDDLE_X], J[MIDDLE_X, 0] = y[0], 1.0
    F[MIDDLE_Z], J[MIDDLE_Z, 2] = y[2], 1.0
    F[MIDDLE_QX], J[MIDDLE_QX, 4] = y[4], 1.0
    F[MIDDLE_QZ], J[MIDDLE_QZ, 6] = y[6], 1.0
    F[MIDDLE_NY], J[MIDDLE_NY, 8] = y[8], 1.0
    F[UNIT] = y[3] * y[3] + y[4] * y[4] + y[5] * y[5] + y[6] * y[6] - 1.0
    for i in range(4):
        J[UNIT, 3 + i] = 2.0 * y[3 + i]
    # k3 u3 = m . d_3 with m = c - w x n
    t = np.empty(3)
    m = np.empty(3)
    E = np.empty((3, 4))
    tangent(y[3:7], t)
    tangent_derivative(y[3:7], E)
    moment(U[CX], U[CZ], y[0:3], y[7:10], m)
    F[TWIST] = m[0] * t[0] + m[1] * t[1] + m[2] * t[2] - k3 * U[U3]
    # d(-(w x n) . t): by w it is -(n x t), by n it is -(t x w)
    w, n = y[0:3], y[7:10]
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        J[TWIST, i] = -(n[j] * t[k] - n[k] * t[j])
        J[TWIST, 7 + i] = -(t[j] * w[k] - t[k] * w[j])
    for i in range(4):
        J[TWIST, 3 + i] = m[0] * E[0, i] + m[1] * E[1, i] + m[2] * E[2, i]
    J[TWIST, CX], J[TWIST, CZ], J[TWIST, U3] = t[0], t[2], -k3
    F[SPHERE] = s[0] * s[0] + s[1] * s[1] + s[2] * s[2] - 0.25
    for i in range(3):
        J[SPHERE, 10 + i] = 2.0 * s[i]
    F[SIDEWAYS], J[SIDEWAYS, WEIGHT] = after[8] - 0.5 * U[WEIGHT], -0.5
    for i in range(10):
        J[SIDEWAYS, 10 + i] = jacobian[8, i]
    J[SIDEWAYS, FGAMMA] = jacobian[8, 10]
    F[CLAMP_X], J[CLAMP_X, 20] = e[0], 1.0
    F[CLAMP_Z], J[CLAMP_Z, 22], J[CLAMP_Z, DELTA] = e[2] - half + 0.5 * U[DELTA], 1.0, 0.5
    F[CLAMP_QX], J[CLAMP_QX, 24] = e[4], 1.0
    F[CLAMP_QY], J[CLAMP_QY, 25] = e[5], 1.0
    cosine, sine = np.cos(0.25 * rotation), np.sin(0.25 * rotation)
    F[CLAMP_TURN] = cosine * e[6] - sine * e[3]
    J[CLAMP_TURN, 26], J[CLAMP_TURN, 23] = cosine, -sine
