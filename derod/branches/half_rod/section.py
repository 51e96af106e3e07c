"""A section with two bending stiffnesses: the rates of eq:18d-equilibre for K1 != K2.

The strains are U_i = M_i/K_i in the material frame (the first line of eq:18d-equilibre before K1 = K2
is put in). With k_i the stiffnesses about d_i in units of K1, the Darboux vector is

    u = m + sum_i (1/k_i - 1) mu_i d_i,    mu_i = m.d_i,    i = 1, 2, 3,

and q' = u q/2. Since d_i q = q e_i, this is q' = (m q + sum_i (1/k_i - 1) mu_i q e_i)/2. The twist
u3 = mu_3/k3 is no longer uniform, m_3' = (k_1 - k_2) u_1 u_2; the parameter u3 is the one at the
rod's middle.

``section`` (3,) is (k3, k_1, k_2). The frame of q has d_2 along e_y, the flip axis, at the middle; which of
the two stiffnesses k_1 is follows from the clamps' directors (``parameters``).
"""

from __future__ import annotations

import numpy as np
from numba import njit

from derod.branches.half_rod import gauss as gauss  # first: it says where kernels are kept


@njit(cache=True, error_model="numpy")
def anisotropic(section):  # type: ignore[no-untyped-def]
    """Whether the two bending stiffnesses differ from 1, and with it the equations from the paper's."""
    return section[1] != 1.0 or section[2] != 1.0


@njit(cache=True, error_model="numpy")
def director(q, axis, out):  # type: ignore[no-untyped-def]
    """d_1 (axis 1) or d_2 (axis 2) of q into out (3,)."""
    w, x, y, z = q[0], q[1], q[2], q[3]
    if axis == 1:
        out[0] = w * w + x * x - y * y - z * z
        out[1] = 2.0 * (x * y + w * z)
        out[2] = 2.0 * (x * z - w * y)
    else:
        out[0] = 2.0 * (x * y - w * z)
        out[1] = w * w - x * x + y * y - z * z
        out[2] = 2.0 * (y * z + w * x)


@njit(cache=True, error_model="numpy")
def director_derivative(q, axis, out):  # type: ignore[no-untyped-def]
    """The derivative of d_axis with respect to q into out (3, 4)."""
    w, x, y, z = 2.0 * q[0], 2.0 * q[1], 2.0 * q[2], 2.0 * q[3]
    if axis == 1:
        out[0, 0], out[0, 1], out[0, 2], out[0, 3] = w, x, -y, -z
        out[1, 0], out[1, 1], out[1, 2], out[1, 3] = z, y, x, w
        out[2, 0], out[2, 1], out[2, 2], out[2, 3] = -y, z, -w, x
    elif axis == 2:
        out[0, 0], out[0, 1], out[0, 2], out[0, 3] = -z, y, x, -w
        out[1, 0], out[1, 1], out[1, 2], out[1, 3] = w, -x, y, -z
        out[2, 0], out[2, 1], out[2, 2], out[2, 3] = x, w, z, y
    else:
        out[0, 0], out[0, 1], out[0, 2], out[0, 3] = y, z, w, x
        out[1, 0], out[1, 1], out[1, 2], out[1, 3] = -x, -w, z, y
        out[2, 0], out[2, 1], out[2, 2], out[2, 3] = w, -x, -y, z


@njit(cache=True, error_model="numpy")
def times_unit(q, axis, out):  # type: ignore[no-untyped-def]
    """q e_axis into out (4,)."""
    if axis == 1:
        out[0], out[1], out[2], out[3] = -q[1], q[0], q[3], -q[2]
    elif axis == 2:
        out[0], out[1], out[2], out[3] = -q[2], -q[3], q[0], q[1]
    else:
        out[0], out[1], out[2], out[3] = -q[3], q[2], -q[1], q[0]


@njit(cache=True, error_model="numpy")
def excess(section, axis):  # type: ignore[no-untyped-def]
    """1/k_axis - 1, the compliance beyond that of K1."""
    return 1.0 / section[axis % 3] - 1.0


@njit(cache=True, error_model="numpy")
def local_twist(m, section, t):  # type: ignore[no-untyped-def]
    """(1 - k3) u3 where u3 = m.d_3/k3 holds at every point; t is d_3."""
    return excess(section, 3) * (m[0] * t[0] + m[1] * t[1] + m[2] * t[2])


@njit(cache=True, error_model="numpy")
def bending_strain(m, section, q, out):  # type: ignore[no-untyped-def]
    """u up to a multiple of d_3 into out (3,), so that d_3' = u x d_3: m itself where K1 = K2."""
    for i in range(3):
        out[i] = m[i]
    if anisotropic(section):
        d = np.empty(3)
        for axis in (1, 2):
            director(q, axis, d)
            f = excess(section, axis) * (m[0] * d[0] + m[1] * d[1] + m[2] * d[2])
            for i in range(3):
                out[i] += f * d[i]


@njit(cache=True, error_model="numpy")
def add_section_rate(m, section, q, out):  # type: ignore[no-untyped-def]
    """Add sum over i = 1, 2 of (1/k_i - 1) mu_i q e_i/2 to the rate q' in out (4,)."""
    d, e = np.empty(3), np.empty(4)
    for axis in (1, 2):
        director(q, axis, d)
        times_unit(q, axis, e)
        f = 0.5 * excess(section, axis) * (m[0] * d[0] + m[1] * d[1] + m[2] * d[2])
        for a in range(4):
            out[a] += f * e[a]


@njit(cache=True, error_model="numpy")
def add_section_by_moment(section, q, t, L):  # type: ignore[no-untyped-def]
    """Add to L (4, 3), the derivative of q' by m, its sum over i of (1/k_i - 1) q e_i d_i/2; t is d_3."""
    d, e = np.empty(3), np.empty(4)
    for axis in (1, 2, 3):
        if axis == 3:
            d[:] = t
        else:
            director(q, axis, d)
        times_unit(q, axis, e)
        f = 0.5 * excess(section, axis)
        for a in range(4):
            for i in range(3):
                L[a, i] += f * e[a] * d[i]


@njit(cache=True, error_model="numpy")
def add_section_by_frame(m, section, q, first, PQ):  # type: ignore[no-untyped-def]
    """Add to PQ (4, 4 m), from column ``first``, the derivative of the sections' part of q' by q, m held.

    What multiplies q e_3 as a number is the own rate's (``condense``), with ``local_twist``.
    """
    d, e, E = np.empty(3), np.empty(4), np.empty((3, 4))
    unit, column = np.zeros(4), np.empty(4)
    for axis in (1, 2, 3):
        f = 0.5 * excess(section, axis)
        times_unit(q, axis, e)
        director_derivative(q, axis, E)
        for b in range(4):
            turned = m[0] * E[0, b] + m[1] * E[1, b] + m[2] * E[2, b]
            for a in range(4):
                PQ[a, first + b] += f * e[a] * turned
        if axis == 3:
            continue
        director(q, axis, d)
        f *= m[0] * d[0] + m[1] * d[1] + m[2] * d[2]
        for b in range(4):
            unit[:] = 0.0
            unit[b] = 1.0
            times_unit(unit, axis, column)
            for a in range(4):
                PQ[a, first + b] += f * column[a]
