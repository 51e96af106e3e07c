r"""Bending, and what bending does to the length of a chord.

Vertex i joins the edges i-1 and i of rest lengths p and q (0 beyond a clamp, whose tangent takes the
missing edge's place). With the turning angle phi and the dual length m/2, m = p + q,

    E_bend = sum_i phi_i^2 / m_i            (K0 = 1, curvature phi / (m/2) on the length m/2)

An edge is the chord of its arc, shorter by kappa^2 l^3 / 24. Half of that is charged to each of its
two vertices in the stretch constraint of edge j,

    g_j = (|e_j|^2 / l_j - l_j) / 2 + l_j^3 (kappa_j^2 + kappa_{j+1}^2) / 48

so that the Lagrangian holds sum_i C_i phi_i^2 with

    C = 1/m + X / (12 m^2),   X = lambda_p p^3 + lambda_q q^3
"""

from __future__ import annotations

from derod.core.angle import squared_angle
from derod.core.jit import kernel


@kernel
def vertex_turn(axis, kin, i, a, b):
    """Copy the tangents that meet at vertex i into ``a`` and ``b``; return u = 1 - cos(phi)."""
    n = kin.rest.size
    u = 0.0
    for k in range(len(axis)):
        a[k] = kin.tangent[i - 1, k] if i > 0 else axis[k]
        b[k] = kin.tangent[i, k] if i < n else axis[k]
        u += (a[k] - b[k]) ** 2
    return 0.5 * u


@kernel
def bending_energy(physics, kin, a, b):
    """Return E_bend, K0/D."""
    n = kin.rest.size
    total = 0.0
    for i in range(n + 1):
        phi2, _, _ = squared_angle(vertex_turn(physics.axis, kin, i, a, b))
        m = (kin.rest[i - 1] if i > 0 else 0.0) + (kin.rest[i] if i < n else 0.0)
        total += phi2 / m
    return total


@kernel
def add_bending_gradient(physics, kin, q, a, b, grad):
    """Add the derivatives of sum C_i phi_i^2 by the edges, the tensions and the rest lengths."""
    n = kin.rest.size
    d = len(physics.axis)
    for i in range(n + 1):
        u = vertex_turn(physics.axis, kin, i, a, b)
        phi2, slope, _ = squared_angle(u)
        left, right = i > 0, i < n
        p = kin.rest[i - 1] if left else 0.0
        r = kin.rest[i] if right else 0.0
        tp = q[i, d] if left else 0.0
        tr = q[i + 1, d] if right else 0.0
        m = p + r
        w = 1.0 / m
        x = tp * p * p * p + tr * r * r * r
        c = w + x * w * w / 12
        cosine = 1 - u
        # du/de_{i-1} = -(b - cos a)/|e_{i-1}|,  du/de_i = -(a - cos b)/|e_i|
        if left:
            f = -c * slope / kin.size[i - 1]
            for k in range(d):
                grad.edge[i - 1, k] += f * (b[k] - cosine * a[k])
            grad.constraint[i - 1] += p * p * p * w * w / 12 * phi2
        if right:
            f = -c * slope / kin.size[i]
            for k in range(d):
                grad.edge[i, k] += f * (a[k] - cosine * b[k])
            grad.constraint[i] += r * r * r * w * w / 12 * phi2
        if left:
            grad.rest[i - 1] += phi2 * w * w * (-1 + tp * p * p / 4 - x * w / 6)
        if right:
            grad.rest[i] += phi2 * w * w * (-1 + tr * r * r / 4 - x * w / 6)


@kernel
def coefficient_slope(w, x, m_s, x_s):
    """Return dC/ds for C = w + x w^2/12, w = 1/m."""
    return w * w * (-m_s + x_s / 12 - x * m_s * w / 6)


@kernel
def add_bending_hessian(physics, kin, q, a, b, hess):
    """Add the second derivatives of sum C_i phi_i^2."""
    n = kin.rest.size
    d = len(physics.axis)
    for i in range(n + 1):
        u = vertex_turn(physics.axis, kin, i, a, b)
        phi2, slope, curve = squared_angle(u)
        left, right = i > 0, i < n
        p = kin.rest[i - 1] if left else 0.0
        r = kin.rest[i] if right else 0.0
        tp = q[i, d] if left else 0.0
        tr = q[i + 1, d] if right else 0.0
        w = 1.0 / (p + r)
        x = tp * p * p * p + tr * r * r * r
        c = w + x * w * w / 12
        cosine = 1 - u
        ie = 1.0 / kin.size[i - 1] if left else 0.0
        jf = 1.0 / kin.size[i] if right else 0.0
        cp = p * p * p * w * w / 12  # dC/dlambda_p
        cr = r * r * r * w * w / 12
        for k in range(d):
            ue_k = -(b[k] - cosine * a[k]) * ie  # du/de_{i-1}
            uf_k = -(a[k] - cosine * b[k]) * jf  # du/de_i
            for m in range(d):
                same = 1.0 if k == m else 0.0
                ue_m = -(b[m] - cosine * a[m]) * ie
                uf_m = -(a[m] - cosine * b[m]) * jf
                if left:
                    u_ee = ie * (cosine * ie * (same - a[k] * a[m]) - a[k] * ue_m - ue_k * a[m])
                    hess.edge[i - 1, k, m] += c * (curve * ue_k * ue_m + slope * u_ee)
                if right:
                    u_ff = jf * (cosine * jf * (same - b[k] * b[m]) - b[k] * uf_m - uf_k * b[m])
                    hess.edge[i, k, m] += c * (curve * uf_k * uf_m + slope * u_ff)
                if left and right:
                    u_ef = -ie * jf * (same - a[k] * a[m] - b[k] * b[m] + cosine * a[k] * b[m])
                    hess.vertex[i, k, m] += c * (curve * ue_k * uf_m + slope * u_ef)
            if left:
                hess.constraint[i - 1, 1, k] += cp * slope * ue_k
                hess.constraint[i - 1, 2, k] += cp * slope * uf_k
            if right:
                hess.constraint[i, 0, k] += cr * slope * ue_k
                hess.constraint[i, 1, k] += cr * slope * uf_k
        for s in range(2):
            p_s = kin.slope[s, i - 1] if left else 0.0
            r_s = kin.slope[s, i] if right else 0.0
            if p_s == 0.0 and r_s == 0.0:
                continue
            m_s = p_s + r_s
            x_s = 3 * (tp * p * p * p_s + tr * r * r * r_s)
            c_s = coefficient_slope(w, x, m_s, x_s)
            if left:
                hess.constraint_menisci[s, i - 1] += phi2 * (
                    p * p * w * w * (3 * p_s - 2 * p * m_s * w) / 12
                )
            if right:
                hess.constraint_menisci[s, i] += phi2 * (
                    r * r * w * w * (3 * r_s - 2 * r * m_s * w) / 12
                )
            for k in range(d):
                if left:
                    hess.edge_menisci[s, i - 1, k] -= c_s * slope * (b[k] - cosine * a[k]) * ie
                if right:
                    hess.edge_menisci[s, i, k] -= c_s * slope * (a[k] - cosine * b[k]) * jf
            for v in range(2):
                p_v = kin.slope[v, i - 1] if left else 0.0
                r_v = kin.slope[v, i] if right else 0.0
                m_v = p_v + r_v
                x_v = 3 * (tp * p * p * p_v + tr * r * r * r_v)
                x_sv = 6 * (tp * p * p_s * p_v + tr * r * r_s * r_v)
                hess.border[s, v] += phi2 * (
                    2 * m_s * m_v * w**3
                    + x_sv * w * w / 12
                    - (x_s * m_v + x_v * m_s) * w**3 / 6
                    + x * m_s * m_v * w**4 / 2
                )
