"""The soft wall of the drop: v(r) = v0 / (1 + rho - 2 r), r = |x - x_C|, over the wetted part.

It is a barrier, singular at r = (1 + rho)/2. At r = 0 the printed potential has a cone, which would
give a rod through the drop's centre a kink; within CORE the distance is replaced by the smooth even
polynomial that meets it with two derivatives, which moves energies by less than v0 CORE^2.

Inner edges are fixed fractions of the wetted length, so an integral over it is s_B - s_A times a fixed
weighted sum over the nodes (``derod.rod.mesh.quadrature``, of fourth order like the rod).
"""

from __future__ import annotations

import math

from derod.algebra.jit import inlined, kernel
from derod.rod.unknowns import S_A, S_B, X_C

CORE = 0.01  # D
CURVED = 0.5  # of the gap that a step leaves, below which it must follow the wall


@inlined
def wall(physics, r2):
    """Return v and its first two derivatives by w = r^2, with the core smoothed."""
    if r2 < CORE * CORE:
        # r = CORE (3/8 + 3/4 y - y^2/8), y = w / CORE^2
        y = r2 / (CORE * CORE)
        r = CORE * (0.375 + 0.75 * y - 0.125 * y * y)
        r_w = (0.75 - 0.25 * y) / CORE
        r_ww = -0.25 / (CORE * CORE * CORE)
    else:
        r = math.sqrt(r2)
        r_w = 0.5 / r
        r_ww = -0.5 * r_w / r2
    inverse = 1.0 / (1 + physics.wall_softness - 2 * r)
    v = physics.wall_strength * inverse
    v_r = 2 * v * inverse
    v_rr = 4 * v_r * inverse
    return v, v_r * r_w, v_rr * r_w * r_w + v_r * r_ww


@inlined
def squared_distance(physics, q, b, i):
    """Return |x_i - x_C|^2."""
    r2 = 0.0
    for k in range(len(physics.axis)):
        r2 += (q[i, k] - b[X_C + k]) ** 2
    return r2


@inlined
def wall_gap(physics, kin, q, b):
    """Return the least 1 + rho - 2 r of the wetted nodes."""
    r2 = 0.0
    for i in range(kin.node_a, kin.node_b + 1):
        r2 = max(r2, squared_distance(physics, q, b, i))
    return 1 + physics.wall_softness - 2 * math.sqrt(r2)


@kernel
def stay_inside(physics, kin, q, b, moved_q, moved_b):
    """Follow the wall where a straight step from (q, b) to (moved_q, moved_b) runs into its curve.

    A step of length s along the wall comes nearer to it by s^2/2r, and a hard wall's gap is soon used up. A
    node for which that matters is put back to the radius that the step's radial part leads to; this
    changes the step to second order only.
    """
    d = len(physics.axis)
    for i in range(kin.node_a, kin.node_b + 1):
        r2, moved_r2, outward = 0.0, 0.0, 0.0
        for k in range(d):
            x = q[i, k] - b[X_C + k]
            y = moved_q[i, k] - moved_b[X_C + k]
            r2 += x * x
            moved_r2 += y * y
            outward += x * (y - x)
        r, moved_r = math.sqrt(r2), math.sqrt(moved_r2)
        if r == 0.0:
            continue
        radial = r + outward / r
        if 1 + physics.wall_softness - 2 * moved_r > CURVED * (
            1 + physics.wall_softness - 2 * radial
        ):
            continue
        for k in range(d):
            y = moved_q[i, k] - moved_b[X_C + k]
            moved_q[i, k] = moved_b[X_C + k] + radial / moved_r * y


@inlined
def energy(physics, kin, q, b, psi):
    """Return the integral of v over the wetted part, K0/D."""
    total = 0.0
    for i in range(kin.node_a, kin.node_b + 1):
        v, _, _ = wall(physics, squared_distance(physics, q, b, i))
        total += kin.share[i] * v
    return (b[S_B] - b[S_A]) * total


@inlined
def add_gradient(physics, kin, q, b, psi, tension, grad):
    """Add the wall's push on the nodes, and its energy by the menisci's places."""
    twice = 2 * (b[S_B] - b[S_A])
    mean = 0.0
    for i in range(kin.node_a, kin.node_b + 1):
        r2 = squared_distance(physics, q, b, i)
        v, v_w, v_ww = wall(physics, r2)
        mean += kin.share[i] * v
        push = twice * kin.share[i] * v_w
        kin.barrier[i] = push + 2 * twice * kin.share[i] * v_ww * r2
        for k in range(len(physics.axis)):
            grad.node[i, k] += push * (q[i, k] - b[X_C + k])
    grad.border[S_A] -= mean
    grad.border[S_B] += mean


@inlined
def add_hessian(physics, kin, q, b, psi, tension, hess):
    """Add the wall's second derivatives; those by x_C follow in ``rod.band`` from the nodes'."""
    d = len(physics.axis)
    wetted = b[S_B] - b[S_A]
    for i in range(kin.node_a, kin.node_b + 1):
        _, v_w, v_ww = wall(physics, squared_distance(physics, q, b, i))
        weight = wetted * kin.share[i]
        by_place = 2 * kin.share[i] * v_w
        for k in range(d):
            x_k = q[i, k] - b[X_C + k]
            hess.node[i, k, k] += 2 * weight * v_w
            for m in range(d):
                hess.node[i, k, m] += 4 * weight * v_ww * x_k * (q[i, m] - b[X_C + m])
            hess.node_menisci[S_A, i, k] -= by_place * x_k
            hess.node_menisci[S_B, i, k] += by_place * x_k
