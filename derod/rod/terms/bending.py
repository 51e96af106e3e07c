r"""Bending, and what bending does to the length of a chord.

Vertex i joins the edges i and i+1 of rest lengths p and r (0 for a clamp's tangent). With the turning
angle phi and the dual length m/2, m = p + r,

    E_bend = sum_i phi_i^2 / m_i            (K0 = 1, curvature phi / (m/2) on the length m/2)

An edge is the chord of its arc, shorter by kappa^2 l^3 / 24. Half of that is charged to each of its
two vertices in the stretch constraint of edge e,

    g_e = (|e|^2 / l - l) / 2 + l^3 (kappa_{e-1}^2 + kappa_e^2) / 48

so that the Lagrangian holds sum_i C_i phi_i^2 with

    C = w + x w^2 / 12,   w = 1/m,   x = lambda_p p^3 + lambda_r r^3
"""

from __future__ import annotations

from derod.algebra.jit import inlined
from derod.rod.angle import SERIES_LIMIT, small_squared_angle, squared_angle


@inlined
def fill_turns(kin, grad):
    """Measure the turning angles, and set the arcs' share of the stretch constraints."""
    small = True
    for i in range(kin.fall.size):
        kin.turn[i], kin.turn_slope[i] = small_squared_angle(kin.fall[i])
        small &= kin.fall[i] < SERIES_LIMIT
    if not small:
        for i in range(kin.fall.size):
            kin.turn[i], kin.turn_slope[i], _ = squared_angle(kin.fall[i])
    share = grad.by_vertex
    for i in range(kin.fall.size):
        share[i] = kin.turn[i] * kin.weight[i] * kin.weight[i] / 12
    for e in range(1, kin.rest.size - 1):
        grad.constraint[e] = (share[e - 1] + share[e]) * kin.rest[e] * kin.rest[e] * kin.rest[e]


@inlined
def energy(physics, kin, q, b, psi):
    """Return E_bend, K/D."""
    total = 0.0
    for i in range(kin.fall.size):
        phi2, _, _ = squared_angle(kin.fall[i])
        total += phi2 * kin.weight[i]
    return total


@inlined
def add_gradient(physics, kin, q, b, psi, tension, grad):
    """Add the derivatives of sum C_i phi_i^2 by directions, duals and rest lengths; after ``fill_turns``.

    C depends on x and the dual: dC/dm = -w^2 - x w^3 / 6, dC/dx = w^2 / 12.
    """
    n = kin.rest.size - 2
    w = kin.weight
    cube, force = grad.by_edge, grad.by_vertex
    for e in range(n + 2):
        cube[e] = tension[e] * kin.rest[e] * kin.rest[e] * kin.rest[e]
    for i in range(n + 1):
        share = kin.turn[i] * w[i] * w[i]
        grad.dual[i] -= share * (1 + (cube[i] + cube[i + 1]) * w[i] / 6)
    for i in range(n + 1):
        force[i] = kin.turn[i] * w[i] * w[i]
    for e in range(1, n + 1):
        grad.rest[e] += 0.25 * tension[e] * kin.rest[e] * kin.rest[e] * (force[e - 1] + force[e])
    for i in range(n + 1):
        x = cube[i] + cube[i + 1]
        force[i] = (w[i] + x * w[i] * w[i] / 12) * kin.turn_slope[i]
    # u = 1 - t_i . t_{i+1}: du/dt_i is the change at i but for a part along t_i, and so is -du/dt_{i+1}
    for k in range(len(physics.axis)):
        for e in range(1, n + 1):
            grad.direction[k, e] += (
                force[e - 1] * kin.change[k, e - 1] - force[e] * kin.change[k, e]
            )


@inlined
def add_hessian(physics, kin, q, b, psi, tension, hess):
    """Add the second derivatives of sum C_i phi_i^2."""
    d = len(physics.axis)
    for i in range(kin.rest.size - 1):
        left, right = hess.tangent[i], hess.tangent[i + 1]
        u = kin.fall[i]
        phi2, slope, curve = squared_angle(u)
        p, r = kin.rest[i], kin.rest[i + 1]
        tp, tr = tension[i], tension[i + 1]
        w = kin.weight[i]
        x = tp * p * p * p + tr * r * r * r
        c = w + x * w * w / 12
        cosine = 1 - u
        ip, ir = kin.inverse[i], kin.inverse[i + 1]
        cp = p * p * p * w * w / 12  # dC/dlambda_p
        cr = r * r * r * w * w / 12
        for k in range(d):
            a_k, b_k = left[k], right[k]
            up_k = -(b_k - cosine * a_k) * ip  # du/de_i
            ur_k = -(a_k - cosine * b_k) * ir  # du/de_{i+1}
            for m in range(d):
                a_m, b_m = left[m], right[m]
                same = 1.0 if k == m else 0.0
                up_m = -(b_m - cosine * a_m) * ip
                ur_m = -(a_m - cosine * b_m) * ir
                u_pp = ip * (cosine * ip * (same - a_k * a_m) - a_k * up_m - up_k * a_m)
                u_rr = ir * (cosine * ir * (same - b_k * b_m) - b_k * ur_m - ur_k * b_m)
                u_pr = -ip * ir * (same - a_k * a_m - b_k * b_m + cosine * a_k * b_m)
                hess.edge[i, k, m] += c * (curve * up_k * up_m + slope * u_pp)
                hess.edge[i + 1, k, m] += c * (curve * ur_k * ur_m + slope * u_rr)
                hess.vertex[i, k, m] += c * (curve * up_k * ur_m + slope * u_pr)
            hess.constraint[i, 1, k] += cp * slope * up_k
            hess.constraint[i, 2, k] += cp * slope * ur_k
            hess.constraint[i + 1, 0, k] += cr * slope * up_k
            hess.constraint[i + 1, 1, k] += cr * slope * ur_k
        for s in range(2):
            p_s, r_s = kin.slope[s, i], kin.slope[s, i + 1]
            if p_s == 0.0 and r_s == 0.0:
                continue
            m_s = p_s + r_s
            x_s = 3 * (tp * p * p * p_s + tr * r * r * r_s)
            c_s = w * w * (-m_s + x_s / 12 - x * m_s * w / 6)
            share = phi2 * w * w / 12
            hess.constraint_menisci[s, i] += share * p * p * (3 * p_s - 2 * p * m_s * w)
            hess.constraint_menisci[s, i + 1] += share * r * r * (3 * r_s - 2 * r * m_s * w)
            for k in range(d):
                a_k, b_k = left[k], right[k]
                hess.edge_menisci[s, i, k] -= c_s * slope * (b_k - cosine * a_k) * ip
                hess.edge_menisci[s, i + 1, k] -= c_s * slope * (a_k - cosine * b_k) * ir
            for v in range(2):
                p_v, r_v = kin.slope[v, i], kin.slope[v, i + 1]
                m_v = p_v + r_v
                x_v = 3 * (tp * p * p * p_v + tr * r * r * r_v)
                x_sv = 6 * (tp * p * p_s * p_v + tr * r * r_s * r_v)
                hess.border[s, v] += phi2 * (
                    2 * m_s * m_v * w**3
                    + x_sv * w * w / 12
                    - (x_s * m_v + x_v * m_s) * w**3 / 6
                    + x * m_s * m_v * w**4 / 2
                )
