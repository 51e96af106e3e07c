"""The drop for a simulator with a fixed mesh: wall, capillarity, and menisci that move through it.

Nodes lie at s_j = (j - 1/2) h. The distance r to the drop's centre is interpolated along the rod by cubic
Hermite splines, so that the first and the last crossing of the sphere, s_A and s_B, are C1 functions of
the nodes' places, and so is the energy

    E = sum_j W_j v(r_j) - f_gamma (s_B - s_A),   W_j = the integral of node j's hat over [s_A, s_B]

Forces are its exact gradient: no force jumps as a meniscus passes a node.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

GAP_LEAST = 0.004  # D; nearer to its pole the wall goes on as a parabola


@njit(cache=True, error_model="numpy")
def wall(r, strength, softness):
    """Return v(r) and its slope; C1 beyond ``GAP_LEAST``, where an explicit step may get to."""
    gap = 1 + softness - 2 * r
    beyond = max(GAP_LEAST - gap, 0.0)
    gap = max(gap, GAP_LEAST)
    v = strength / gap
    v_r = 2 * v / gap
    curve = 4 * v_r / gap
    return v + 0.5 * v_r * beyond + 0.125 * curve * beyond**2, v_r + 0.5 * curve * beyond


@njit(cache=True, error_model="numpy")
def hermite(u, basis, slope):
    """Fill the weights of the nodes i-1 ... i+2 of the spline at i + u, and their derivatives."""
    basis[0] = 0.5 * (-u + 2 * u**2 - u**3)
    basis[1] = 0.5 * (2 - 5 * u**2 + 3 * u**3)
    basis[2] = 0.5 * (u + 4 * u**2 - 3 * u**3)
    basis[3] = 0.5 * (-(u**2) + u**3)
    slope[0] = 0.5 * (-1 + 4 * u - 3 * u**2)
    slope[1] = 0.5 * (-10 * u + 9 * u**2)
    slope[2] = 0.5 * (1 + 8 * u - 9 * u**2)
    slope[3] = 0.5 * (-2 * u + 3 * u**2)


@njit(cache=True, error_model="numpy")
def crossing(r, first, step, basis, slope):
    """Return (i, u) of the first place r = 1/2 from the end ``first``; ``basis, slope`` are filled."""
    i = first + 2 * step
    while r[i] > 0.5 and 2 <= i + step < r.size - 2:
        i += step
    if step > 0:
        i -= 1  # the crossing lies between i and i+1
    low, high = 0.0, 1.0
    for _ in range(60):
        u = 0.5 * (low + high)
        hermite(u, basis, slope)
        value = basis[0] * r[i - 1] + basis[1] * r[i] + basis[2] * r[i + 1] + basis[3] * r[i + 2]
        if (value > 0.5) == (step > 0):
            low = u
        else:
            high = u
    return i, 0.5 * (low + high)


@njit(cache=True, error_model="numpy")
def hat_integral(t):
    """Return the integral of the unit hat at 0, from -inf to t."""
    if t <= -1:
        return 0.0
    if t >= 1:
        return 1.0
    return 0.5 * (1 + t) ** 2 if t < 0 else 1 - 0.5 * (1 - t) ** 2


@njit(cache=True, error_model="numpy")
def drop_forces(x, centre, h, strength, softness, capillary, r, force, pull):
    """Fill ``force`` (3, n) on the nodes at ``x`` and ``pull`` (3,) on the drop.

    Returns (E_wall, E_capillary, s_A / h, s_B / h), places counted in nodes.
    """
    n = x.shape[1]
    for j in range(n):
        r[j] = math.sqrt(
            (x[0, j] - centre[0]) ** 2 + (x[1, j] - centre[1]) ** 2 + (x[2, j] - centre[2]) ** 2
        )
    force[:] = 0.0
    ends = np.zeros(2)
    basis, slope = np.zeros((2, 4)), np.zeros((2, 4))
    cells = np.zeros(2, np.int64)
    for side in range(2):
        i, u = crossing(
            r, 0 if side == 0 else n - 1, 1 if side == 0 else -1, basis[side], slope[side]
        )
        cells[side], ends[side] = i, i + u
    energy = 0.0
    jump = np.array([capillary, -capillary])  # dE/ds_A, dE/ds_B
    for j in range(max(cells[0] - 1, 0), min(cells[1] + 3, n)):
        weight = h * (hat_integral(ends[1] - j) - hat_integral(ends[0] - j))
        v, v_r = wall(r[j], strength, softness)
        energy += weight * v
        jump[0] -= max(1 - abs(ends[0] - j), 0.0) * v
        jump[1] += max(1 - abs(ends[1] - j), 0.0) * v
        for k in range(3):
            force[k, j] -= weight * v_r * (x[k, j] - centre[k]) / (r[j] + 1e-12)
    for side in range(2):
        i = cells[side]
        rise = 0.0
        for m in range(4):
            rise += slope[side, m] * r[i - 1 + m]
        for m in range(4):
            j = i - 1 + m
            push = jump[side] * h * basis[side, m] / rise  # ds/dr_j = -h basis / rise
            for k in range(3):
                force[k, j] += push * (x[k, j] - centre[k]) / (r[j] + 1e-12)
    for k in range(3):
        pull[k] = -np.sum(force[k])
    return energy, -capillary * h * (ends[1] - ends[0]), ends[0], ends[1]
