r"""The second-order defect of discrete bending, given back.

On edges of length h the energy sum phi^2/(2h) of a smooth curve is too low by (h^2/12) int |kappa'|^2,
kappa' the covariant derivative of the curvature (kappa'^2 + kappa^2 torsion^2): half of it because an
edge's direction is a mean over the edge, half because a cell's curvature is a mean over the cell. With

    E_defect = sum_e (l_e / 12) F,   F = |d|^2,   d = (1 - t t^T) s,   s = alpha t_+ + beta t_-

the rod is of higher order. t is the tangent of edge e, t_- and t_+ those of its neighbours, and
beta = 2/(l_{e-1} + l_e), alpha = 2/(l_e + l_{e+1}) the inverse dual lengths between them: d is the
difference of the curvatures at the edge's two ends. Beyond the clamps t_-, t_+ are the clamps' tangents.
"""

from __future__ import annotations

from derod.algebra.jit import inlined


@inlined
def squared_difference(axis, kin, e):
    """Return F of edge e."""
    square = 0.0
    for k in range(len(axis)):
        square += kin.difference[k, e] ** 2
    return square


@inlined
def energy(physics, kin, q, b, psi):
    """Return E_defect, K/D; it is part of the bending energy."""
    total = 0.0
    for e in range(1, kin.rest.size - 1):
        total += kin.rest[e] / 12 * squared_difference(physics.axis, kin, e)
    return total


@inlined
def add_gradient(physics, kin, q, b, psi, tension, grad):
    """Add the derivatives of E_defect by directions, duals and rest lengths.

    With d perpendicular to t: dF/dt_+ = 2 alpha d, dF/dt_- = 2 beta d, dF/dt = -2 sigma d, and
    d.t_+, -d.t_- are d's products with the changes of t.
    """
    n = kin.rest.size - 2
    d, w, rest = kin.difference, kin.weight, kin.rest
    for k in range(len(physics.axis)):
        for e in range(1, n + 1):
            grad.direction[k, e] += (
                w[e - 1] * rest[e - 1] * d[k, e - 1]
                + w[e] * rest[e + 1] * d[k, e + 1]
                - 0.5 * rest[e] * kin.along[e] * d[k, e]
            ) / 3
    for i in range(n + 1):
        turning = 0.0
        for k in range(len(physics.axis)):
            turning += kin.change[k, i] * (rest[i + 1] * d[k, i + 1] - rest[i] * d[k, i])
        grad.by_vertex[i] = turning
    for i in range(n + 1):
        grad.dual[i] += w[i] * w[i] * grad.by_vertex[i] / 3
    for e in range(1, n + 1):
        grad.rest[e] += squared_difference(physics.axis, kin, e) / 12


@inlined
def add_hessian(physics, kin, q, b, psi, tension, hess):
    """Add the second derivatives of E_defect.

    F is a function of three unit vectors; that an edge's direction is one adds, for a first derivative
    G by the direction u, -((G.u) (1 - u u^T) + G_perp u^T + u G_perp^T)/|e|^2.
    """
    n = len(physics.axis)
    for e in range(1, kin.rest.size - 1):
        alpha, beta = 2 * kin.weight[e], 2 * kin.weight[e - 1]
        d, sigma, square = (
            hess.difference[e],
            kin.along[e],
            squared_difference(physics.axis, kin, e),
        )
        o, r, l = hess.tangent[e], hess.tangent[e + 1], hess.tangent[e - 1]
        io, ir, il = kin.inverse[e], kin.inverse[e + 1], kin.inverse[e - 1]
        right, left, cr, cl, cx = 0.0, 0.0, 0.0, 0.0, 0.0
        for k in range(n):
            right += d[k] * r[k]
            left += d[k] * l[k]
            cr += o[k] * r[k]
            cl += o[k] * l[k]
            cx += l[k] * r[k]
        weight = kin.rest[e] / 6
        cross = cx - cr * cl
        for k in range(n):
            # components across the neighbours: of d, of t; and of t's neighbours across t
            dr_k, dl_k = d[k] - right * r[k], d[k] - left * l[k]
            or_k, ol_k = o[k] - cr * r[k], o[k] - cl * l[k]
            ro_k = r[k] - cr * o[k]
            for m in range(n):
                same = 1.0 if k == m else 0.0
                dr_m, dl_m = d[m] - right * r[m], d[m] - left * l[m]
                or_m, ol_m = o[m] - cr * r[m], o[m] - cl * l[m]
                lo_m = l[m] - cl * o[m]
                hess.edge[e, k, m] += (
                    weight
                    * io
                    * io
                    * (
                        -d[k] * d[m]
                        + sigma * (sigma * (same - o[k] * o[m]) + d[k] * o[m] + o[k] * d[m])
                    )
                )
                hess.edge[e + 1, k, m] += (
                    weight
                    * alpha
                    * ir
                    * ir
                    * (
                        alpha * (same - r[k] * r[m] - or_k * or_m)
                        - right * (same - r[k] * r[m])
                        - dr_k * r[m]
                        - r[k] * dr_m
                    )
                )
                hess.edge[e - 1, k, m] += (
                    weight
                    * beta
                    * il
                    * il
                    * (
                        beta * (same - l[k] * l[m] - ol_k * ol_m)
                        - left * (same - l[k] * l[m])
                        - dl_k * l[m]
                        - l[k] * dl_m
                    )
                )
                # rows: edge e, columns: edge e+1; and rows: e-1, columns: e
                hess.vertex[e, k, m] -= (
                    weight
                    * alpha
                    * io
                    * ir
                    * (d[k] * or_m + sigma * (same - o[k] * o[m] - ro_k * r[m]))
                )
                hess.vertex[e - 1, k, m] -= (
                    weight
                    * beta
                    * io
                    * il
                    * (ol_k * d[m] + sigma * (same - o[k] * o[m] - l[k] * lo_m))
                )
                # rows: e-1, columns: e+1 of (1 - l l^T)(1 - t t^T)(1 - r r^T)
                hess.skip[e, k, m] += (
                    weight
                    * alpha
                    * beta
                    * il
                    * ir
                    * (same - l[k] * l[m] - ol_k * or_m - (r[k] - cx * l[k]) * r[m])
                )
        add_rest_lengths(kin, e, d, alpha, beta, sigma, square, right, left, cr, cl, cross, hess)


@inlined
def add_rest_lengths(kin, e, d, alpha, beta, sigma, square, right, left, cr, cl, cross, hess):
    """Add the second derivatives of (l_e/12) F in which s_A and s_B take part."""
    o, r, l = hess.tangent[e], hess.tangent[e + 1], hess.tangent[e - 1]
    io, ir, il = kin.inverse[e], kin.inverse[e + 1], kin.inverse[e - 1]
    length = kin.rest[e]
    for s in range(2):
        l_s = kin.slope[s, e]
        sum_r, sum_l = l_s + kin.slope[s, e + 1], l_s + kin.slope[s, e - 1]
        if l_s == 0.0 and sum_r == 0.0 and sum_l == 0.0:
            continue
        a_s, b_s = -0.5 * alpha * alpha * sum_r, -0.5 * beta * beta * sum_l
        for k in range(d.size):
            ro_k, lo_k = r[k] - cr * o[k], l[k] - cl * o[k]
            # d_s = a_s (t_+)_perp + b_s (t_-)_perp and sigma_s, of d and sigma
            d_s = a_s * ro_k + b_s * lo_k
            by_r = alpha * (l_s * d[k] + length * d_s) + length * a_s * d[k]
            by_l = beta * (l_s * d[k] + length * d_s) + length * b_s * d[k]
            sigma_s = a_s * cr + b_s * cl
            by_o = l_s * sigma * d[k] + length * (sigma_s * d[k] + sigma * d_s)
            along_r, along_l = 0.0, 0.0
            for m in range(d.size):
                dm_s = a_s * (r[m] - cr * o[m]) + b_s * (l[m] - cl * o[m])
                along_r += r[m] * (alpha * (l_s * d[m] + length * dm_s) + length * a_s * d[m])
                along_l += l[m] * (beta * (l_s * d[m] + length * dm_s) + length * b_s * d[m])
            hess.edge_menisci[s, e + 1, k] += ir / 6 * (by_r - along_r * r[k])
            hess.edge_menisci[s, e - 1, k] += il / 6 * (by_l - along_l * l[k])
            hess.edge_menisci[s, e, k] -= io / 6 * by_o
        for v in range(2):
            l_v = kin.slope[v, e]
            more_r, more_l = l_v + kin.slope[v, e + 1], l_v + kin.slope[v, e - 1]
            a_v, b_v = -0.5 * alpha * alpha * more_r, -0.5 * beta * beta * more_l
            f_s, f_v = 2 * (right * a_s + left * b_s), 2 * (right * a_v + left * b_v)
            f_sv = (
                2 * (1 - cr * cr) * a_s * a_v
                + 2 * (1 - cl * cl) * b_s * b_v
                + 2 * cross * (a_s * b_v + b_s * a_v)
                + right * alpha**3 * sum_r * more_r
                + left * beta**3 * sum_l * more_l
            )
            hess.border[s, v] += (l_s * f_v + l_v * f_s + length * f_sv) / 12
