"""Inextensibility: one multiplier an edge, which is the tension (equa:inext-constr).

lambda_e g_e,   g_e = (|e|^2 / l - l) / 2 + (the arc's share, see ``bending``)
"""

from __future__ import annotations

from derod.algebra.jit import inlined


@inlined
def fill_chords(kin, grad):
    """Add the chords' share of the constraints g."""
    for e in range(1, kin.rest.size - 1):
        ratio = kin.size[e] / kin.rest[e]
        grad.constraint[e] += 0.5 * kin.rest[e] * (ratio - 1) * (ratio + 1)


@inlined
def add_gradient(physics, kin, q, b, psi, tension, grad):
    """Set the pull lambda |e| / l along the edges; add the derivatives by the rest lengths."""
    for e in range(1, kin.rest.size - 1):
        grad.pull[e] = tension[e] * kin.size[e] / kin.rest[e]
    for e in range(1, kin.rest.size - 1):
        ratio = kin.size[e] / kin.rest[e]
        grad.rest[e] -= 0.5 * tension[e] * (ratio * ratio + 1)


@inlined
def add_hessian(physics, kin, q, b, psi, tension, hess):
    """Add the second derivatives of lambda_e g_e."""
    d = len(physics.axis)
    for e in range(1, kin.rest.size - 1):
        ratio = kin.size[e] / kin.rest[e]
        stiffness = tension[e] / kin.rest[e]
        for k in range(d):
            hess.edge[e, k, k] += stiffness
            hess.constraint[e, 1, k] += ratio * kin.tangent[k, e]
        for s in range(2):
            l_s = kin.slope[s, e]
            if l_s == 0.0:
                continue
            hess.constraint_menisci[s, e] -= 0.5 * (ratio * ratio + 1) * l_s
            for k in range(d):
                hess.edge_menisci[s, e, k] -= stiffness * ratio * kin.tangent[k, e] * l_s
            for v in range(2):
                hess.border[s, v] += stiffness * ratio * ratio * l_s * kin.slope[v, e]
