"""Inextensibility: one multiplier an edge, which is the tension (equa:inext-constr).

    lambda_j g_j,   g_j = (|e_j|^2 / l_j - l_j) / 2 + (the arc's share, see ``bending``)
"""

from __future__ import annotations

from derod.core.jit import kernel


@kernel
def add_stretch_gradient(physics, kin, q, grad):
    """Add lambda_j e_j / l_j by the edges, g_j by the tensions, and by the rest lengths."""
    d = len(physics.axis)
    for j in range(kin.rest.size):
        ratio = kin.size[j] / kin.rest[j]
        tension = q[j + 1, d]
        for k in range(d):
            grad.edge[j, k] += tension * ratio * kin.tangent[j, k]
        grad.constraint[j] += 0.5 * kin.rest[j] * (ratio - 1) * (ratio + 1)
        grad.rest[j] -= 0.5 * tension * (ratio * ratio + 1)


@kernel
def add_stretch_hessian(physics, kin, q, hess):
    """Add the second derivatives of lambda_j g_j."""
    d = len(physics.axis)
    for j in range(kin.rest.size):
        ratio = kin.size[j] / kin.rest[j]
        tension = q[j + 1, d]
        stiffness = tension / kin.rest[j]
        for k in range(d):
            hess.edge[j, k, k] += stiffness
            hess.constraint[j, 1, k] += ratio * kin.tangent[j, k]
        for s in range(2):
            l_s = kin.slope[s, j]
            if l_s == 0.0:
                continue
            hess.constraint_menisci[s, j] -= 0.5 * (ratio * ratio + 1) * l_s
            for k in range(d):
                hess.edge_menisci[s, j, k] -= stiffness * ratio * kin.tangent[j, k] * l_s
            for v in range(2):
                hess.border[s, v] += stiffness * ratio * ratio * l_s * kin.slope[v, j]
