r"""The rod's own elliptic operator as a fictitious mass, constraints beside it in one bordered band.

For an inextensible rod the bending energy is int |r''|^2 / 2 whatever its shape: its second variation
differs from that of a straight rod by terms of lower order, a compact perturbation. A mass M made of

    bending of a straight rod on the present mesh, with the defect's share (``bending``, ``defect``)
    the outer tension, t |u'|^2
    the wall's blocks and 2 |f| at the menisci, against the drop's centre; ``CENTRE`` on that by itself
    2 (|f_A| + |f_B|) + ``CENTRE`` on half the growth g of the wetted length, with u -> u - C g
    k3/l grad psi grad psi^T, the twist's row

bounds the Hessian H of the Lagrangian from both sides: on the constraints the eigenvalues of M^{-1} H lie
in an interval that does not know the mesh, but for a few soft modes (``tests/equilibrium/test_elliptic.py``).
Gradients taken in such an inner product are Sobolev gradients (Neuberger 1997); as a preconditioner M is
a norm-equivalent operator (Faber, Manteuffel and Parter 1990). Constraints A are kept beside it,

    [[M, A^T], [A, 0]],

in the layout and the arrays of the Hessian (``assembly``), so that the same factorisation solves it.

C carries every node along the tangent with its arc length as g grows. The tangent at a node must be of
second order there, (l_{i+1} t_i + l_i t_{i+1}) / (l_i + l_{i+1}): the plain mean has a kink wherever edges
change their length, whose bending grows like 1/h.
"""

from __future__ import annotations

from derod.algebra.bordered import subtract_product
from derod.algebra.jit import inlined, kernel
from derod.rod.angle import squared_angle
from derod.rod.assembly import clear_hessian, hold_idle
from derod.rod.band import fill_band, fill_border
from derod.rod.constraints import on_sphere, pin
from derod.rod.terms import wall
from derod.rod.unknowns import F_A, S_A, S_B, X_C

CENTRE = 0.1  # K0/D^3, of the drop's centre and of the wetted length by themselves


@kernel
def fill_operator(physics, q, b, room, factor):
    """Fill ``room.linear`` with [[M, A^T], [A, 0]] at the state whose ``gradient`` was taken last.

    The turn of the coil about the clamp axis has mass like any motion: its row is idle. ``factor`` lends
    its right sides; ``room.hess.tangent`` keeps the tangents of this state.
    """
    d = len(physics.axis)
    kin, hess, linear = room.kin, room.hess, room.linear
    clear_hessian(physics.axis, kin, hess)
    add_straight_bending(d, kin, hess)
    add_arc_rows(d, kin, hess)
    add_chord_rows(d, kin, hess)
    wetted = 0.0
    if physics.drop:
        add_outer_tension(d, kin, room.tension, hess)
        wetted = add_drop(physics, kin, q, b, room.tension, hess)
    else:
        hold_idle(d, hess)
    fill_band(physics, hess, linear.band)
    fill_border(physics, q, b, False, room)
    if physics.drop:
        carry_wetted(d, kin, linear, factor, wetted)


@inlined
def add_straight_bending(d, kin, hess):
    """Add the second derivatives of bending and defect at the straight rod, alike in all directions.

    With the change u_e = de_e / l_e of a tangent (0 at the clamps) they are those of

        sum_i w_i |u_{i+1} - u_i|^2 + sum_e (l_e / 12) |alpha (u_{e+1} - u_e) - beta (u_e - u_{e-1})|^2
    """
    rest, w = kin.rest, kin.weight
    n = rest.size - 2
    for i in range(n + 1):
        left = -1.0 / rest[i] if i > 0 else 0.0
        right = 1.0 / rest[i + 1] if i < n else 0.0
        for k in range(d):
            hess.edge[i, k, k] += 2 * w[i] * left * left
            hess.edge[i + 1, k, k] += 2 * w[i] * right * right
            hess.vertex[i, k, k] += 2 * w[i] * left * right
    for e in range(1, n + 1):
        left = 2 * w[e - 1] / rest[e - 1] if e > 1 else 0.0
        own = -2 * (w[e - 1] + w[e]) / rest[e]
        right = 2 * w[e] / rest[e + 1] if e < n else 0.0
        share = rest[e] / 6
        for k in range(d):
            hess.edge[e - 1, k, k] += share * left * left
            hess.edge[e, k, k] += share * own * own
            hess.edge[e + 1, k, k] += share * right * right
            hess.vertex[e - 1, k, k] += share * left * own
            hess.vertex[e, k, k] += share * own * right
            hess.skip[e, k, k] += share * left * right


@inlined
def add_outer_tension(d, kin, tension, hess):
    """Add the tension lambda / l of the edges outside the drop, where it pulls."""
    for e in range(1, kin.rest.size - 1):
        if kin.node_a < e <= kin.node_b:
            continue
        for k in range(d):
            hess.edge[e, k, k] += max(tension[e], 0.0) / kin.rest[e]


@inlined
def add_arc_rows(d, kin, hess):
    """Add the arcs' share of the constraints' derivatives, l^3 (kappa_{e-1}^2 + kappa_e^2) / 48 each."""
    for i in range(kin.rest.size - 1):
        phi2, slope, _ = squared_angle(kin.fall[i])
        cosine = 1 - kin.fall[i]
        w, p, r = kin.weight[i], kin.rest[i], kin.rest[i + 1]
        by_p, by_r = slope * p * p * p * w * w / 12, slope * r * r * r * w * w / 12
        for k in range(d):
            a, b = kin.tangent[k, i], kin.tangent[k, i + 1]
            left, right = -(b - cosine * a) * kin.inverse[i], -(a - cosine * b) * kin.inverse[i + 1]
            hess.constraint[i, 1, k] += by_p * left
            hess.constraint[i, 2, k] += by_p * right
            hess.constraint[i + 1, 0, k] += by_r * left
            hess.constraint[i + 1, 1, k] += by_r * right
        share = phi2 * w * w / 12
        for s in range(2):
            p_s, r_s = kin.slope[s, i], kin.slope[s, i + 1]
            m_s = p_s + r_s
            hess.constraint_menisci[s, i] += share * p * p * (3 * p_s - 2 * p * m_s * w)
            hess.constraint_menisci[s, i + 1] += share * r * r * (3 * r_s - 2 * r * m_s * w)


@inlined
def add_chord_rows(d, kin, hess):
    """Add the chords' share of the constraints' derivatives, (|e|^2 / l - l) / 2 each."""
    for e in range(1, kin.rest.size - 1):
        ratio = kin.size[e] / kin.rest[e]
        for k in range(d):
            hess.constraint[e, 1, k] += ratio * kin.tangent[k, e]
        for s in range(2):
            hess.constraint_menisci[s, e] -= 0.5 * (ratio * ratio + 1) * kin.slope[s, e]


@inlined
def add_drop(physics, kin, q, b, tension, hess):
    """Add the wall's and the menisci's blocks and constraints; return the wetted length's own mass."""
    d = len(physics.axis)
    wall.add_hessian(physics, kin, q, b, 0.0, tension, hess)
    hess.node_menisci[:] = 0.0  # the wetted length is coupled by what it carries
    on_sphere.add_hessian(physics, kin, q, b, 0.0, tension, hess)
    pin.add_hessian(physics, kin, q, b, 0.0, tension, hess)
    wetted = CENTRE
    for side in range(2):
        i = kin.node_a if side == 0 else kin.node_b
        force = b[F_A + d + side]
        wetted += 2 * abs(force)
        for k in range(d):
            hess.node[i, k, k] += 2 * (abs(force) - force)
    for k in range(d):
        hess.border[X_C + k, X_C + k] += CENTRE
    return wetted


@inlined
def carry_wetted(d, kin, linear, factor, wetted):
    """Let the wetted length carry the nodes: M on u - C g, and ``wetted`` on g = (s_B - s_A)/2.

    The columns of s_A, s_B become +-M C / 2, their corner (C^T M C + wetted) / 4.
    """
    x, out, out_border = factor.rhs, factor.right, factor.right_border
    border, corner = linear.border, linear.corner
    x[:] = 0.0
    factor.rhs_border[:] = 0.0
    out[:] = 0.0
    out_border[:] = 0.0
    n = kin.rest.size - 2
    place = 0.0
    for i in range(1, n):
        place += kin.slope[1, i] - kin.slope[0, i]
        l, r = place * kin.weight[i] * kin.rest[i + 1], place * kin.weight[i] * kin.rest[i]
        for k in range(d):
            x[(d + 1) * (i - 1) + k] = l * kin.tangent[k, i] + r * kin.tangent[k, i + 1]
    subtract_product(linear, x, factor.rhs_border, out, out_border)
    own = wetted
    for i in range(1, n):
        for k in range(d):
            j = (d + 1) * (i - 1) + k
            border[j, S_A] -= 0.5 * out[j]
            border[j, S_B] += 0.5 * out[j]
            own -= x[j] * out[j]
    for k in range(X_C, F_A + d):
        corner[S_A, k] -= 0.5 * out_border[k]
        corner[S_B, k] += 0.5 * out_border[k]
        corner[k, S_A] = corner[S_A, k]
        corner[k, S_B] = corner[S_B, k]
    corner[S_A, S_A] += 0.25 * own
    corner[S_B, S_B] += 0.25 * own
    corner[S_A, S_B] -= 0.25 * own
    corner[S_B, S_A] -= 0.25 * own
