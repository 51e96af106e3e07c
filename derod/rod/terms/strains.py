r"""Energies that depend on strains v of the frames, to fourth order; ``section`` and ``torsion`` share them.

With stiffnesses k_2 (beyond the first) and k_3, forces c_1, c_2, c_3 of the natural shape, and h = m/2 the
length of a vertex's cell,

    E = sum_i (k_2 v_2^2 + k_3 v_3^2) / m - c.v  +  sum_e F_e

The sum over cells misses terms of second order: a strain is a mean over its cell (an eighth of h^2 u_3' turns
the frame against the cell's middle, two rotations do not commute, an edge is a chord), and F gives them back.
With the mean a and the difference d of u = 2v/m at the two ends of an edge of length l,

    F = l (k_2 d_2^2/12 + k_3 d_3^2/24) + l^2 T + l^3 U
    T = (k_2/24 - k_3/8) a_1 a_3 d_2 + (k_3 - k_2)/8 a_2 a_3 d_1 + k_2/12 a_1 a_2 d_3
        + c_1 (a_2 d_3/12 - a_3 d_2/8) - c_2 (a_1 d_3/12 - a_3 d_1/8) + c_3 (a_1 d_2 - a_2 d_1)/8
    U = 5 k_2/24 a_2^2 a_3^2 - k_3/8 a_3^2 (a_1^2 + a_2^2)
        - 5/24 (c_1 a_1 + c_2 a_2) a_3^2 + c_3/8 a_3 (a_1^2 + a_2^2)

It follows from the expansion of v in u and its derivatives at the middle of a cell (docs/model.md).
"""

from __future__ import annotations

from derod.algebra.jit import inlined, kernel


@kernel
def energy(k2, k3, natural, kin, frames):
    """Return E, K/D; 0 for a rod without frames."""
    if frames is None:
        return 0.0
    total = 0.0
    v = frames.strain
    for i in range(v.shape[1]):
        total += kin.weight[i] * (k2 * v[1, i] ** 2 + k3 * v[2, i] ** 2)
        total -= natural[0] * v[0, i] + natural[1] * v[1, i] + natural[2] * v[2, i]
    for e in range(1, kin.rest.size - 1):
        l, a1, a2, a3, d1, d2, d3 = ends(kin, e, frames)
        total += l * (k2 * d2 * d2 / 12 + k3 * d3 * d3 / 24)
        total += l * l * bilinear(k2, k3, natural, a1, a2, a3, d1, d2, d3)
        total += l * l * l * cubic(k2, k3, natural, a1, a2, a3)
    return total


@inlined
def ends(kin, e, frames):
    """Return l, the mean and the difference of u at the ends of an edge."""
    p, q = 2 * kin.weight[e - 1], 2 * kin.weight[e]
    v = frames.strain
    p1, p2, p3 = p * v[0, e - 1], p * v[1, e - 1], p * v[2, e - 1]
    q1, q2, q3 = q * v[0, e], q * v[1, e], q * v[2, e]
    return (
        kin.rest[e],
        0.5 * (p1 + q1), 0.5 * (p2 + q2), 0.5 * (p3 + q3), q1 - p1, q2 - p2, q3 - p3,
    )  # fmt: skip


@inlined
def bilinear(k2, k3, natural, a1, a2, a3, d1, d2, d3):
    """Return T."""
    value = (k2 / 24 - k3 / 8) * a1 * a3 * d2 + (k3 - k2) / 8 * a2 * a3 * d1
    value += k2 / 12 * a1 * a2 * d3
    value += natural[0] * (a2 * d3 / 12 - a3 * d2 / 8)
    value -= natural[1] * (a1 * d3 / 12 - a3 * d1 / 8)
    return value + natural[2] * (a1 * d2 - a2 * d1) / 8


@inlined
def cubic(k2, k3, natural, a1, a2, a3):
    """Return U."""
    square = a1 * a1 + a2 * a2
    value = 5 * k2 / 24 * a2 * a2 * a3 * a3 - k3 / 8 * a3 * a3 * square
    value -= 5 / 24 * (natural[0] * a1 + natural[1] * a2) * a3 * a3
    return value + natural[2] / 8 * a3 * square


@inlined
def parts(k2, k3, natural, a1, a2, a3, d1, d2, d3):
    """Return the derivatives of T by a and by d, and those of U by a."""
    c1, c2, c3 = natural
    p1, p2, p3 = k2 / 24 - k3 / 8, (k3 - k2) / 8, k2 / 12
    square = a1 * a1 + a2 * a2
    by_mean = (
        p1 * a3 * d2 + p3 * a2 * d3 - c2 * d3 / 12 + c3 * d2 / 8,
        p2 * a3 * d1 + p3 * a1 * d3 + c1 * d3 / 12 - c3 * d1 / 8,
        p1 * a1 * d2 + p2 * a2 * d1 - c1 * d2 / 8 + c2 * d1 / 8,
    )
    by_difference = (
        p2 * a2 * a3 + c2 * a3 / 8 - c3 * a2 / 8,
        p1 * a1 * a3 - c1 * a3 / 8 + c3 * a1 / 8,
        p3 * a1 * a2 + c1 * a2 / 12 - c2 * a1 / 12,
    )
    u3 = 5 * k2 / 12 * a2 * a2 * a3 - k3 / 4 * a3 * square
    u3 += -5 / 12 * (c1 * a1 + c2 * a2) * a3 + c3 / 8 * square
    cubed = (
        -k3 / 4 * a1 * a3 * a3 - 5 * c1 / 24 * a3 * a3 + c3 / 4 * a1 * a3,
        (5 * k2 / 12 - k3 / 4) * a2 * a3 * a3 - 5 * c2 / 24 * a3 * a3 + c3 / 4 * a2 * a3,
        u3,
    )
    return by_mean, by_difference, cubed


@kernel
def add_gradient(k2, k3, natural, kin, grad, frames):
    """Add the derivatives of E by strains, rest and dual lengths."""
    if frames is None:
        return
    v, by, w, f = frames.strain, frames.by_strain, kin.weight, frames.slopes
    for i in range(v.shape[1]):
        by[0, i] -= natural[0]
        by[1, i] += 2 * w[i] * k2 * v[1, i] - natural[1]
        by[2, i] += 2 * w[i] * k3 * v[2, i] - natural[2]
        grad.dual[i] -= w[i] * w[i] * (k2 * v[1, i] ** 2 + k3 * v[2, i] ** 2)
    for e in range(1, kin.rest.size - 1):
        fill_slopes(k2, k3, natural, kin, e, frames)
        grad.rest[e] += f[6]
        for side in range(2):
            i = e - 1 + side
            for j in range(3):
                by[j, i] += 2 * w[i] * f[3 * side + j]
                grad.dual[i] -= 2 * w[i] * w[i] * v[j, i] * f[3 * side + j]


@inlined
def fill_slopes(k2, k3, natural, kin, e, frames):
    """Fill the derivatives of F by u before the edge, u behind it, and l."""
    l, a1, a2, a3, d1, d2, d3 = ends(kin, e, frames)
    f = frames.slopes
    t, s, u = parts(k2, k3, natural, a1, a2, a3, d1, d2, d3)
    ll, lll = l * l, l * l * l
    by_a1, by_a2, by_a3 = ll * t[0] + lll * u[0], ll * t[1] + lll * u[1], ll * t[2] + lll * u[2]
    by_d1, by_d2, by_d3 = ll * s[0], ll * s[1] + l * k2 * d2 / 6, ll * s[2] + l * k3 * d3 / 12
    f[0], f[3] = 0.5 * by_a1 - by_d1, 0.5 * by_a1 + by_d1
    f[1], f[4] = 0.5 * by_a2 - by_d2, 0.5 * by_a2 + by_d2
    f[2], f[5] = 0.5 * by_a3 - by_d3, 0.5 * by_a3 + by_d3
    f[6] = k2 * d2 * d2 / 12 + k3 * d3 * d3 / 24
    f[6] += 2 * l * bilinear(k2, k3, natural, a1, a2, a3, d1, d2, d3)
    f[6] += 3 * ll * cubic(k2, k3, natural, a1, a2, a3)


@kernel
def add_hessian(k2, k3, natural, kin, hess, frames):
    """Add the second derivatives of E by strains, rest and dual lengths."""
    if frames is None:
        return
    v, w = frames.strain, kin.weight
    for i in range(v.shape[1]):
        frames.own[i, 1, 1] += 2 * w[i] * k2
        frames.own[i, 2, 2] += 2 * w[i] * k3
        for s in range(2):
            m_s = kin.slope[s, i] + kin.slope[s, i + 1]
            frames.menisci[s, i, 1] -= 2 * w[i] ** 2 * m_s * k2 * v[1, i]
            frames.menisci[s, i, 2] -= 2 * w[i] ** 2 * m_s * k3 * v[2, i]
            for r in range(2):
                m_r = kin.slope[r, i] + kin.slope[r, i + 1]
                force = k2 * v[1, i] ** 2 + k3 * v[2, i] ** 2
                hess.border[s, r] += 2 * w[i] ** 3 * m_s * m_r * force
    for e in range(1, kin.rest.size - 1):
        fill_slopes(k2, k3, natural, kin, e, frames)
        fill_curves(k2, k3, natural, kin, e, frames)
        for side in range(2):
            i = e - 1 + side
            for j in range(3):
                for m in range(3):
                    second = frames.curves[3 * side + j, 3 * side + m]
                    frames.own[i, j, m] += 4 * w[i] ** 2 * second
        for j in range(3):
            for m in range(3):
                frames.next[e, j, m] += 4 * w[e - 1] * w[e] * frames.curves[j, 3 + m]
        add_rest_lengths(kin, e, hess, frames)


@inlined
def add_rest_lengths(kin, e, hess, frames):
    """Add the second derivatives of F in which s_A and s_B take part: u_s = -u m_s/m."""
    v, w, f, c = frames.strain, kin.weight, frames.slopes, frames.curves
    for s in range(2):
        l_s = kin.slope[s, e]
        p_s = -2 * w[e - 1] ** 2 * (kin.slope[s, e - 1] + l_s)  # u_s = p_s v
        q_s = -2 * w[e] ** 2 * (l_s + kin.slope[s, e + 1])
        if l_s == 0.0 and p_s == 0.0 and q_s == 0.0:
            continue
        for side in range(2):
            i = e - 1 + side
            own_s = p_s if side == 0 else q_s
            for j in range(3):
                row = 3 * side + j
                mixed = c[row, 6] * l_s
                for k in range(3):
                    mixed += c[row, k] * p_s * v[k, e - 1] + c[row, 3 + k] * q_s * v[k, e]
                frames.menisci[s, i, j] += own_s * f[row] + 2 * w[i] * mixed
        for r in range(2):
            l_r = kin.slope[r, e]
            p_r = -2 * w[e - 1] ** 2 * (kin.slope[r, e - 1] + l_r)
            q_r = -2 * w[e] ** 2 * (l_r + kin.slope[r, e + 1])
            total = c[6, 6] * l_s * l_r
            for j in range(3):
                x, y = v[j, e - 1], v[j, e]
                total += c[6, j] * x * (l_s * p_r + l_r * p_s)
                total += c[6, 3 + j] * y * (l_s * q_r + l_r * q_s)
                total += f[j] * x * p_s * p_r / w[e - 1] + f[3 + j] * y * q_s * q_r / w[e]
                for k in range(3):
                    total += c[j, k] * x * v[k, e - 1] * p_s * p_r
                    total += c[3 + j, 3 + k] * y * v[k, e] * q_s * q_r
                    total += c[j, 3 + k] * x * v[k, e] * (p_s * q_r + p_r * q_s)
            hess.border[s, r] += total


@inlined
def fill_curves(k2, k3, natural, kin, e, frames):
    """Fill the second derivatives of F by u before the edge, u behind it, and l."""
    l, a1, a2, a3, d1, d2, d3 = ends(kin, e, frames)
    c1, c2, c3 = natural
    c = frames.curves
    ll, lll = l * l, l * l * l
    p1, p2, p3 = k2 / 24 - k3 / 8, (k3 - k2) / 8, k2 / 12
    square = a1 * a1 + a2 * a2
    # by a and a (aa), by a row and d column (ad), by d and d (dd)
    aa11 = lll * (-k3 / 4 * a3 * a3 + c3 / 4 * a3)
    aa22 = aa11 + lll * 5 * k2 / 12 * a3 * a3
    aa33 = lll * (5 * k2 / 12 * a2 * a2 - k3 / 4 * square - 5 / 12 * (c1 * a1 + c2 * a2))
    aa12 = ll * p3 * d3
    aa13 = ll * p1 * d2 + lll * (-k3 / 2 * a1 * a3 - 5 / 12 * c1 * a3 + c3 / 4 * a1)
    aa23 = ll * p2 * d1 + lll * ((5 * k2 / 6 - k3 / 2) * a2 * a3 - 5 / 12 * c2 * a3 + c3 / 4 * a2)
    ad12, ad13 = ll * (p1 * a3 + c3 / 8), ll * (p3 * a2 - c2 / 12)
    ad21, ad23 = ll * (p2 * a3 - c3 / 8), ll * (p3 * a1 + c1 / 12)
    ad31, ad32 = ll * (p2 * a2 + c2 / 8), ll * (p1 * a1 - c1 / 8)
    aa = ((aa11, aa12, aa13), (aa12, aa22, aa23), (aa13, aa23, aa33))
    ad = ((0.0, ad12, ad13), (ad21, 0.0, ad23), (ad31, ad32, 0.0))
    dd = (0.0, l * k2 / 6, l * k3 / 12)
    t, s, u = parts(k2, k3, natural, a1, a2, a3, d1, d2, d3)
    two, three = 2 * l, 3 * ll
    al = (two * t[0] + three * u[0], two * t[1] + three * u[1], two * t[2] + three * u[2])
    dl = (two * s[0], two * s[1] + k2 * d2 / 6, two * s[2] + k3 * d3 / 12)
    for j in range(3):
        for m in range(3):
            both, skew = ad[j][m] + ad[m][j], ad[j][m] - ad[m][j]
            own = dd[j] if j == m else 0.0
            c[j, m] = 0.25 * aa[j][m] - 0.5 * both + own
            c[3 + j, 3 + m] = 0.25 * aa[j][m] + 0.5 * both + own
            c[j, 3 + m] = 0.25 * aa[j][m] + 0.5 * skew - own
            c[3 + m, j] = c[j, 3 + m]
        c[j, 6] = c[6, j] = 0.5 * al[j] - dl[j]
        c[3 + j, 6] = c[6, 3 + j] = 0.5 * al[j] + dl[j]
    c[6, 6] = 2 * bilinear(k2, k3, natural, a1, a2, a3, d1, d2, d3)
    c[6, 6] += 6 * l * cubic(k2, k3, natural, a1, a2, a3)
