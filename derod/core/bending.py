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

from derod.core.angle import SERIES_LIMIT, small_squared_angle, squared_angle
from derod.core.jit import kernel


@kernel
def vertex_turn(axis, tangent, i):
    """Return u = 1 - cos(phi) at vertex i."""
    u = 0.0
    for k in range(len(axis)):
        u += (tangent[i, k] - tangent[i + 1, k]) ** 2
    return 0.5 * u


@kernel
def fill_turns(physics, kin, grad):
    """Measure the turning angles, and set the arcs' share of the stretch constraints.

    The loops are apart so that the series runs on several vertices at once.
    """
    for i in range(kin.rest.size - 1):
        kin.fall[i] = vertex_turn(physics.axis, kin.tangent, i)
    small = True
    for i in range(kin.rest.size - 1):
        kin.turn[i], kin.turn_slope[i] = small_squared_angle(kin.fall[i])
        small &= kin.fall[i] < SERIES_LIMIT
    if not small:
        for i in range(kin.rest.size - 1):
            kin.turn[i], kin.turn_slope[i], _ = squared_angle(kin.fall[i])
    before = 0.0  # the first vertex's share of its second edge
    for i in range(kin.rest.size - 1):
        p, r = kin.rest[i], kin.rest[i + 1]
        share = kin.turn[i] * kin.weight[i] * kin.weight[i] / 12
        grad.constraint[i] = before + share * p * p * p
        before = share * r * r * r
    grad.constraint[kin.rest.size - 1] = before


@kernel
def bending_energy(physics, kin):
    """Return E_bend, K0/D."""
    total = 0.0
    for i in range(kin.rest.size - 1):
        phi2, _, _ = squared_angle(vertex_turn(physics.axis, kin.tangent, i))
        total += phi2 / (kin.rest[i] + kin.rest[i + 1])
    return total


@kernel
def fill_bending_gradient(physics, kin, tension, grad):
    """Set the derivatives of sum C_i phi_i^2 by the edges and the rest lengths; after ``fill_turns``."""
    tangent = kin.tangent
    grad.edge[0] = 0.0
    grad.rest[0] = 0.0
    for i in range(kin.rest.size - 1):
        cosine = 1 - kin.fall[i]
        p, r = kin.rest[i], kin.rest[i + 1]
        tp, tr = tension[i], tension[i + 1]
        w = kin.weight[i]
        p2, r2 = p * p, r * r
        x = tp * p2 * p + tr * r2 * r
        # du/de_i = -(b - cos a)/|e_i|,  du/de_{i+1} = -(a - cos b)/|e_{i+1}|
        f = -(w + x * w * w / 12) * kin.turn_slope[i]
        fp = f * kin.inverse[i]
        fr = f * kin.inverse[i + 1]
        for k in range(len(physics.axis)):
            a, b = tangent[i, k], tangent[i + 1, k]
            grad.edge[i, k] += fp * (b - cosine * a)
            grad.edge[i + 1, k] = fr * (a - cosine * b)
        share = kin.turn[i] * w * w
        grad.rest[i] += share * (-1 + tp * p2 / 4 - x * w / 6)
        grad.rest[i + 1] = share * (-1 + tr * r2 / 4 - x * w / 6)


@kernel
def add_bending_hessian(physics, kin, tension, hess):
    """Add the second derivatives of sum C_i phi_i^2."""
    d = len(physics.axis)
    tangent = kin.tangent
    for i in range(kin.rest.size - 1):
        u = vertex_turn(physics.axis, tangent, i)
        phi2, slope, curve = squared_angle(u)
        p, r = kin.rest[i], kin.rest[i + 1]
        tp, tr = tension[i], tension[i + 1]
        w = 1.0 / (p + r)
        x = tp * p * p * p + tr * r * r * r
        c = w + x * w * w / 12
        cosine = 1 - u
        ip, ir = kin.inverse[i], kin.inverse[i + 1]
        cp = p * p * p * w * w / 12  # dC/dlambda_p
        cr = r * r * r * w * w / 12
        for k in range(d):
            a_k, b_k = tangent[i, k], tangent[i + 1, k]
            up_k = -(b_k - cosine * a_k) * ip  # du/de_i
            ur_k = -(a_k - cosine * b_k) * ir  # du/de_{i+1}
            for m in range(d):
                a_m, b_m = tangent[i, m], tangent[i + 1, m]
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
                a_k, b_k = tangent[i, k], tangent[i + 1, k]
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
