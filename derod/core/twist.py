r"""Twist of an isotropic rod: one scalar, by the holonomy of parallel transport.

The twist is uniform (equa_M3: M_3' = 0), so that

    E_twist = k3 (R - psi)^2 / (2 l),   m_3 = k3 (R - psi) / l

with R the end rotation and psi the angle by which parallel transport from clamp to clamp turns a
cross-section. The transport over vertex i is the least rotation that carries the tangent a to b; its
quaternion is (1 + a.b, a x b), and the product of all is (cos psi/2, sin psi/2 e_z): psi modulo 4 pi.
The state remembers psi and takes the nearest branch. Over a vertex, with (kb)/2 = a x b/(1 + a.b),

    d psi = -(kb)/2 . (de_i/|e_i| + de_{i+1}/|e_{i+1}|)            (Bergou et al. 2008, 2010)

The polygon of tangents cuts the corners of a smooth tangent curve on the unit sphere, and misses the
area (h^2/8) int kappa^2 torsion: a third of it because an edge's direction is a mean, two thirds because
arcs are replaced by great circles. It is given back edge by edge, (1/8) t_- . (t x t_+).
"""

from __future__ import annotations

import math

from derod.core.bending import vertex_turn
from derod.core.jit import kernel


@kernel
def cross(tangent, i):
    """Return a x b of the tangents that meet at vertex i."""
    a0, a1, a2 = tangent[i, 0], tangent[i, 1], tangent[i, 2]
    b0, b1, b2 = tangent[i + 1, 0], tangent[i + 1, 1], tangent[i + 1, 2]
    return a1 * b2 - a2 * b1, a2 * b0 - a0 * b2, a0 * b1 - a1 * b0


@kernel
def holonomy(physics, kin, remembered, grad):
    """Return psi on the branch nearest to ``remembered``, radians; fill grad(psi) by the edges.

    After ``fill_turns``. Three dimensions only.
    """
    w, x, y, z = 1.0, 0.0, 0.0, 0.0
    slope = grad.holonomy
    slope[0] = 0.0
    for i in range(kin.rest.size - 1):
        px, py, pz = cross(kin.tangent, i)
        pw = 2 - kin.fall[i]  # 1 + a.b
        inverse = 1.0 / pw
        left, right = inverse * kin.inverse[i], inverse * kin.inverse[i + 1]
        slope[i, 0] -= px * left
        slope[i, 1] -= py * left
        slope[i, 2] -= pz * left
        slope[i + 1, 0] = -px * right
        slope[i + 1, 1] = -py * right
        slope[i + 1, 2] = -pz * right
        px, py, pz, pw = 0.5 * px, 0.5 * py, 0.5 * pz, 0.5 * pw
        w, x, y, z = (
            pw * w - px * x - py * y - pz * z,
            pw * x + px * w + py * z - pz * y,
            pw * y - px * z + py * w + pz * x,
            pw * z + px * y - py * x + pz * w,
        )
    missed = 0.0
    for e in range(1, kin.rest.size - 1):
        missed += corner_area(kin, e, slope)
    psi = 2 * math.atan2(z, w) + missed
    turn = 4 * math.pi
    return psi + turn * math.floor((remembered - psi) / turn + 0.5)


@kernel
def corner_area(kin, e, slope):
    """Return (1/8) t_- . (t x t_+) of edge e, and add its gradient to ``slope``."""
    l0, l1, l2 = kin.tangent[e - 1, 0], kin.tangent[e - 1, 1], kin.tangent[e - 1, 2]
    o0, o1, o2 = kin.tangent[e, 0], kin.tangent[e, 1], kin.tangent[e, 2]
    r0, r1, r2 = kin.tangent[e + 1, 0], kin.tangent[e + 1, 1], kin.tangent[e + 1, 2]
    x0, x1, x2 = o1 * r2 - o2 * r1, o2 * r0 - o0 * r2, o0 * r1 - o1 * r0
    area = l0 * x0 + l1 * x1 + l2 * x2
    il, io, ir = 0.125 * kin.inverse[e - 1], 0.125 * kin.inverse[e], 0.125 * kin.inverse[e + 1]
    slope[e - 1, 0] += il * (x0 - area * l0)
    slope[e - 1, 1] += il * (x1 - area * l1)
    slope[e - 1, 2] += il * (x2 - area * l2)
    slope[e, 0] += io * (r1 * l2 - r2 * l1 - area * o0)
    slope[e, 1] += io * (r2 * l0 - r0 * l2 - area * o1)
    slope[e, 2] += io * (r0 * l1 - r1 * l0 - area * o2)
    slope[e + 1, 0] += ir * (l1 * o2 - l2 * o1 - area * r0)
    slope[e + 1, 1] += ir * (l2 * o0 - l0 * o2 - area * r1)
    slope[e + 1, 2] += ir * (l0 * o1 - l1 * o0 - area * r2)
    return 0.125 * area


@kernel
def cross_component(a, b, k):
    """Return component k of a x b."""
    k1, k2 = (k + 1) % 3, (k + 2) % 3
    return a[k1] * b[k2] - a[k2] * b[k1]


@kernel
def twisting_moment(physics, end_rotation, psi):
    """Return m_3 = k3 (R - psi)/l, K0/D."""
    return physics.twisting * (end_rotation - psi) / physics.length


@kernel
def add_twist_gradient(kin, moment, grad):
    """Add -m_3 grad(psi) by the edges; ``holonomy`` has filled grad(psi)."""
    for e in range(1, kin.rest.size - 1):
        for k in range(3):
            grad.edge[e, k] -= moment * grad.holonomy[e, k]


@kernel
def add_twist_hessian(physics, kin, moment, hess):
    """Add -m_3 times the second derivatives of psi; k3/l grad psi grad psi is a border row.

    By one edge twice, the vertices' parts have antisymmetric halves that cancel in the sum: they are
    left out.
    """
    for i in range(kin.rest.size - 1):
        u = vertex_turn(physics.axis, kin.tangent, i)
        cosine = 1 - u
        inverse = 1.0 / (2 - u)
        normal = cross(kin.tangent, i)  # a x b, of which the binormal is ``inverse`` times
        a, b = kin.tangent[i], kin.tangent[i + 1]
        ip, ir = kin.inverse[i], kin.inverse[i + 1]
        add_own_edge(normal, a, b, cosine, inverse, 0.5 * moment * ip * ip, hess.edge[i])
        add_own_edge(normal, b, a, cosine, inverse, 0.5 * moment * ir * ir, hess.edge[i + 1])
        scale = moment * inverse * ip * ir
        for k in range(3):
            k1, k2 = (k + 1) % 3, (k + 2) % 3
            for m in range(3):
                # ([a]x - binormal a^T) (1 - b b^T)
                entry = -inverse * normal[k] * (a[m] - cosine * b[m]) - normal[k] * b[m]
                if m == k2:
                    entry += a[k1]
                elif m == k1:
                    entry -= a[k2]
                hess.vertex[i, k, m] += scale * entry
    for e in range(1, kin.rest.size - 1):
        add_corner_hessian(kin, e, -0.125 * moment, hess)


@kernel
def add_corner_hessian(kin, e, weight, hess):
    """Add ``weight`` times the second derivatives of t_- . (t x t_+) by the edges."""
    l, o, r = kin.tangent[e - 1], kin.tangent[e], kin.tangent[e + 1]
    il, io, ir = kin.inverse[e - 1], kin.inverse[e], kin.inverse[e + 1]
    area = 0.0
    for k in range(3):
        area += l[k] * cross_component(o, r, k)
    for k in range(3):
        # first derivatives across each direction
        gl_k = cross_component(o, r, k) - area * l[k]
        go_k = cross_component(r, l, k) - area * o[k]
        gr_k = cross_component(l, o, k) - area * r[k]
        for m in range(3):
            gl_m = cross_component(o, r, m) - area * l[m]
            go_m = cross_component(r, l, m) - area * o[m]
            gr_m = cross_component(l, o, m) - area * r[m]
            same = 1.0 if k == m else 0.0
            hess.edge[e - 1, k, m] -= (
                weight * il * il * (area * (same - l[k] * l[m]) + gl_k * l[m] + l[k] * gl_m)
            )
            hess.edge[e, k, m] -= (
                weight * io * io * (area * (same - o[k] * o[m]) + go_k * o[m] + o[k] * go_m)
            )
            hess.edge[e + 1, k, m] -= (
                weight * ir * ir * (area * (same - r[k] * r[m]) + gr_k * r[m] + r[k] * gr_m)
            )
            # the triple product is linear in each: rows l, columns o of -[r]x, and so on, projected
            hess.vertex[e - 1, k, m] += weight * il * io * mixed(r, l, o, area, k, m, -1.0)
            hess.vertex[e, k, m] += weight * io * ir * mixed(l, o, r, area, k, m, -1.0)
            hess.skip[e, k, m] += weight * il * ir * mixed(o, l, r, area, k, m, 1.0)


@kernel
def mixed(axis, row, column, area, k, m, sign):
    """Return entry k, m of (1 - row row^T) sign [axis]x (1 - column column^T).

    row . [axis]x column, times sign, is the triple product ``area`` itself.
    """
    k1, k2 = (k + 1) % 3, (k + 2) % 3
    entry = 0.0
    if m == k2:
        entry = axis[k1]
    elif m == k1:
        entry = -axis[k2]
    entry -= cross_component(axis, column, k) * column[m]
    entry -= row[k] * cross_component(row, axis, m)
    return sign * entry + area * row[k] * column[m]


@kernel
def add_own_edge(normal, own, other, cosine, inverse, scale, block):
    """Add twice the symmetric part of |e|^2 d(binormal/|e|)/de, times ``scale``.

    ``normal`` is a x b, the same for both edges: ([b]x a) and ([a]x b) differ in sign, and so do the
    two edges' derivatives of a x b.
    """
    for k in range(3):
        for m in range(3):
            # (-/+ [other]x - binormal other^T) (1 - own own^T) inverse - binormal own^T
            entry = -inverse * (other[m] - cosine * own[m]) - 2 * own[m]
            entry *= scale * inverse * normal[k]
            block[k, m] += entry
            block[m, k] += entry
