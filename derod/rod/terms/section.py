r"""A section with two bending stiffnesses, and what a natural curvature adds (``rod.bending``, two values).

Bending about d_1 costs K_1 = K, which ``bending`` charges in every direction; about d_2 it costs more:

    E = int (K_2 - K_1) u_2^2 / 2 - K_1 k_1 u_1 - K_2 k_2 u_2 ds + (K_1 k_1^2 + K_2 k_2^2) l / 2

with the natural curvature (k_1, k_2), so that the whole bending energy is
K_1 (u_1 - k_1)^2 / 2 + K_2 (u_2 - k_2)^2 / 2. The discrete form, of fourth order, is in ``terms.strains``.
"""

from __future__ import annotations

from derod.algebra.jit import inlined
from derod.rod.terms import strains


@inlined
def forces(physics):
    """Return the forces of the natural shape, K_1 k_1 and K_2 k_2, and none along the rod."""
    hard = (1 + physics.stiffening) * physics.natural_curvature_2
    return physics.natural_curvature_1, hard, 0.0


@inlined
def energy(physics, kin, q, b, psi):
    """Return the energy, K/D."""
    c = forces(physics)
    k1, k2 = physics.natural_curvature_1, physics.natural_curvature_2
    constant = 0.5 * physics.length * (c[0] * k1 + c[1] * k2)
    return constant + strains.energy(physics.stiffening, 0.0, c, kin, kin.frames)


@inlined
def add_gradient(physics, kin, q, b, psi, tension, grad):
    """Add its derivatives by strains and lengths."""
    strains.add_gradient(physics.stiffening, 0.0, forces(physics), kin, grad, kin.frames)


@inlined
def add_hessian(physics, kin, q, b, psi, tension, hess):
    """Add its second derivatives."""
    strains.add_hessian(physics.stiffening, 0.0, forces(physics), kin, hess, kin.frames)
