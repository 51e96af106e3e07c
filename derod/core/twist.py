r"""Twist of an isotropic rod: one scalar, by the holonomy of parallel transport.

The twist is uniform (equa_M3: M_3' = 0), so that

    E_twist = k3 (R - psi)^2 / (2 l),   m_3 = k3 (R - psi) / l

with R the end rotation and psi the angle by which parallel transport from clamp to clamp turns a
cross-section. The transport over vertex i is the least rotation that carries the tangent a to b; its
quaternion is (1 + a.b, a x b), and the product of all is (cos psi/2, sin psi/2 e_z): psi modulo 4 pi.
The state remembers psi and takes the nearest branch. Over a vertex with (kb)/2 = a x b/(1 + a.b),
    d psi = -(kb)/2 . (de_{i-1}/|e_{i-1}| + de_i/|e_i|).
 Gradient and Hessian: Bergou et al. 2008, 2010.
"""

from __future__ import annotations

import math

from derod.core.bending import vertex_turn
from derod.core.jit import kernel


@kernel
def holonomy(physics, kin, remembered, a, b):
    """Return psi on the branch nearest to ``remembered``, radians (three dimensions only)."""
    w, x, y, z = 1.0, 0.0, 0.0, 0.0
    for i in range(kin.rest.size + 1):
        u = vertex_turn(physics.axis, kin, i, a, b)
        pw = 1 - 0.5 * u  # (1 + a.b)/2, and (a x b)/2
        px = 0.5 * (a[1] * b[2] - a[2] * b[1])
        py = 0.5 * (a[2] * b[0] - a[0] * b[2])
        pz = 0.5 * (a[0] * b[1] - a[1] * b[0])
        w, x, y, z = (
            pw * w - px * x - py * y - pz * z,
            pw * x + px * w + py * z - pz * y,
            pw * y - px * z + py * w + pz * x,
            pw * z + px * y - py * x + pz * w,
        )
    psi = 2 * math.atan2(z, w)
    turn = 4 * math.pi
    return psi + turn * math.floor((remembered - psi) / turn + 0.5)


@kernel
def twisting_moment(physics, end_rotation, psi):
    """Return m_3 = k3 (R - psi)/l, K0/D."""
    return physics.twisting * (end_rotation - psi) / physics.length


@kernel
def add_twist_gradient(physics, kin, moment, a, b, grad):
    """Add -m_3 grad(psi) by the edges, and keep grad(psi) itself in ``grad.holonomy``."""
    n = kin.rest.size
    grad.holonomy[:] = 0.0
    for i in range(n + 1):
        u = vertex_turn(physics.axis, kin, i, a, b)
        inverse = 1.0 / (2 - u)  # 1 / (1 + a.b)
        for k in range(3):
            k1, k2 = (k + 1) % 3, (k + 2) % 3
            binormal = (a[k1] * b[k2] - a[k2] * b[k1]) * inverse
            if i > 0:
                grad.holonomy[i - 1, k] -= binormal / kin.size[i - 1]
            if i < n:
                grad.holonomy[i, k] -= binormal / kin.size[i]
    for j in range(n):
        for k in range(3):
            grad.edge[j, k] -= moment * grad.holonomy[j, k]


@kernel
def add_twist_hessian(physics, kin, moment, a, b, binormal, hess):
    """Add -m_3 times the second derivatives of psi; k3/l grad psi grad psi is a border row.

    By one edge twice, the vertices' parts have antisymmetric halves that cancel in the sum: they are
    left out.
    """
    n = kin.rest.size
    for i in range(n + 1):
        u = vertex_turn(physics.axis, kin, i, a, b)
        inverse = 1.0 / (2 - u)
        for k in range(3):
            k1, k2 = (k + 1) % 3, (k + 2) % 3
            binormal[k] = (a[k1] * b[k2] - a[k2] * b[k1]) * inverse
        if i > 0:
            scale = 0.5 * moment / kin.size[i - 1] ** 2
            add_own_edge(binormal, a, b, u, inverse, scale, -1.0, hess.edge[i - 1])
        if i < n:
            scale = 0.5 * moment / kin.size[i] ** 2
            add_own_edge(binormal, b, a, u, inverse, scale, 1.0, hess.edge[i])
        if 0 < i < n:
            scale = moment * inverse / (kin.size[i - 1] * kin.size[i])
            cosine = 1 - u
            for k in range(3):
                k1, k2 = (k + 1) % 3, (k + 2) % 3
                # rows of ([a]x - binormal a^T) (1 - b b^T)
                cross = a[k1] * b[k2] - a[k2] * b[k1]
                for m in range(3):
                    entry = -binormal[k] * (a[m] - cosine * b[m]) - cross * b[m]
                    if m == k2:
                        entry += a[k1]
                    elif m == k1:
                        entry -= a[k2]
                    hess.vertex[i, k, m] += scale * entry


@kernel
def add_own_edge(binormal, own, other, u, inverse, scale, sign, block):
    """Add twice the symmetric part of d(binormal/|e|)/de |e|^2, times ``scale``."""
    cosine = 1 - u
    for k in range(3):
        k1, k2 = (k + 1) % 3, (k + 2) % 3
        # (sign [other]x - binormal other^T) (1 - own own^T) inverse - binormal own^T
        turned = sign * (other[k1] * own[k2] - other[k2] * own[k1])
        for m in range(3):
            entry = -binormal[k] * (other[m] - cosine * own[m]) - turned * own[m]
            entry = entry * inverse - binormal[k] * own[m]
            block[k, m] += scale * entry
            block[m, k] += scale * entry
