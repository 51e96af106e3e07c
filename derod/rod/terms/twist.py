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

from derod.algebra.jit import inlined


@inlined
def fill_normals(kin):
    """Fill the cross products a x b of the tangents that meet at each vertex."""
    for k in range(3):
        k1, k2 = (k + 1) % 3, (k + 2) % 3
        a1, a2, normal = kin.tangent[k1], kin.tangent[k2], kin.normal[k]
        for i in range(kin.fall.size):
            normal[i] = a1[i] * a2[i + 1] - a2[i] * a1[i + 1]


@inlined
def holonomy(kin, remembered, grad):
    """Return psi on the branch nearest to ``remembered``, radians; fill grad(psi) by the edges.

    Three dimensions only.
    """
    fill_normals(kin)
    w, x, y, z = 1.0, 0.0, 0.0, 0.0
    missed = 0.0
    t, normal = kin.tangent, kin.normal
    for i in range(kin.fall.size):
        px, py, pz = 0.5 * normal[0, i], 0.5 * normal[1, i], 0.5 * normal[2, i]
        pw = 1 - 0.5 * kin.fall[i]  # (1 + a.b) / 2
        w, x, y, z = (
            pw * w - px * x - py * y - pz * z,
            pw * x + px * w + py * z - pz * y,
            pw * y - px * z + py * w + pz * x,
            pw * z + px * y - py * x + pz * w,
        )
        if i > 0:  # the corner of edge i
            missed += t[0, i - 1] * px + t[1, i - 1] * py + t[2, i - 1] * pz
    fill_holonomy_gradient(kin, grad)
    psi = 2 * math.atan2(z, w) + 0.25 * missed
    turn = 4 * math.pi
    return psi + turn * math.floor((remembered - psi) / turn + 0.5)


@inlined
def fill_holonomy_gradient(kin, grad):
    """Fill grad(psi): of the polygon, -(kb)/2 of both vertices, and of the corners' triple products.

    By its three directions the corner of edge e has t x t_+, t_+ x t_-, t_- x t over 8; the clamps'
    tangents do not move, and have no corners.
    """
    n = kin.rest.size - 2
    t, normal, weight = kin.tangent, kin.normal, grad.by_vertex
    for i in range(n + 1):
        weight[i] = 1.0 / (2 - kin.fall[i])
    for k in range(3):
        k1, k2 = (k + 1) % 3, (k + 2) % 3
        slope, own, t1, t2 = grad.holonomy[k], normal[k], t[k1], t[k2]
        for e in range(1, n + 1):
            slope[e] = -weight[e - 1] * own[e - 1] - weight[e] * own[e]
        for e in range(1, n + 1):
            slope[e] += 0.125 * (t1[e + 1] * t2[e - 1] - t2[e + 1] * t1[e - 1])
        for e in range(1, n):
            slope[e] += 0.125 * own[e + 1]
        for e in range(1, n):
            slope[e + 1] += 0.125 * own[e - 1]
    for e in range(1, n + 1):
        dot = 0.0
        for k in range(3):
            dot += t[k, e] * grad.holonomy[k, e]
        grad.by_edge[e] = dot
    for k in range(3):
        for e in range(1, n + 1):
            slope = grad.holonomy[k, e] - grad.by_edge[e] * t[k, e]
            grad.holonomy[k, e] = kin.inverse[e] * slope


@inlined
def cross_component(a, b, k):
    """Return component k of a x b."""
    k1, k2 = (k + 1) % 3, (k + 2) % 3
    return a[k1] * b[k2] - a[k2] * b[k1]


@inlined
def twisting_moment(physics, psi):
    """Return m_3 = k3 (R - psi)/l, K/D."""
    return physics.twisting * (physics.end_rotation - psi) / physics.length


@inlined
def energy(physics, kin, q, b, psi):
    """Return E_twist, K/D."""
    return 0.5 * twisting_moment(physics, psi) * (physics.end_rotation - psi)


@inlined
def add_gradient(physics, kin, q, b, psi, tension, grad):
    """Add -m_3 grad(psi) by the edges; ``holonomy`` has filled grad(psi)."""
    moment = twisting_moment(physics, psi)
    for k in range(3):
        for e in range(1, kin.rest.size - 1):
            grad.edge[k, e] -= moment * grad.holonomy[k, e]


@inlined
def add_hessian(physics, kin, q, b, psi, tension, hess):
    """Add -m_3 times the second derivatives of psi; k3/l grad psi grad psi is a border row.

    By one edge twice, the vertices' parts have antisymmetric halves that cancel in the sum: they are
    left out.
    """
    moment = twisting_moment(physics, psi)
    for i in range(kin.rest.size - 1):
        cosine = 1 - kin.fall[i]
        inverse = 1.0 / (2 - kin.fall[i])
        # a x b, of which the binormal is ``inverse`` times
        normal = kin.normal[0, i], kin.normal[1, i], kin.normal[2, i]
        left, right = hess.tangent[i], hess.tangent[i + 1]
        ip, ir = kin.inverse[i], kin.inverse[i + 1]
        add_own_edge(normal, left, right, cosine, inverse, 0.5 * moment * ip * ip, hess.edge[i])
        add_own_edge(normal, right, left, cosine, inverse, 0.5 * moment * ir * ir, hess.edge[i + 1])
        scale = moment * inverse * ip * ir
        for k in range(3):
            k1, k2 = (k + 1) % 3, (k + 2) % 3
            for m in range(3):
                # ([a]x - binormal a^T) (1 - b b^T)
                entry = -inverse * normal[k] * (left[m] - cosine * right[m]) - normal[k] * right[m]
                if m == k2:
                    entry += left[k1]
                elif m == k1:
                    entry -= left[k2]
                hess.vertex[i, k, m] += scale * entry
    for e in range(1, kin.rest.size - 1):
        add_corner_hessian(kin, e, -0.125 * moment, hess)


@inlined
def add_corner_hessian(kin, e, weight, hess):
    """Add ``weight`` times the second derivatives of t_- . (t x t_+) by the edges."""
    l, o, r = hess.tangent[e - 1], hess.tangent[e], hess.tangent[e + 1]
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


@inlined
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


@inlined
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
