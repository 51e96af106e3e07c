r"""Twist of a rod whose section has directions: it need not be uniform (``twist`` is for isotropic rods).

    E = int K_3 (u_3 - tau_0)^2 / 2 ds

with the natural twist tau_0 (``rod.natural_twist``). The discrete form, of fourth order, is in
``terms.strains``.
"""

from __future__ import annotations

from derod.algebra.jit import inlined
from derod.rod.terms import strains


@inlined
def energy(physics, kin, q, b, psi):
    """Return the energy, K/D."""
    k3, rate = physics.torsion, physics.natural_twist
    constant = 0.5 * physics.length * k3 * rate * rate
    return constant + strains.energy(0.0, k3, (0.0, 0.0, k3 * rate), kin, kin.frames)


@inlined
def add_gradient(physics, kin, q, b, psi, tension, grad):
    """Add its derivatives by strains and lengths."""
    natural = (0.0, 0.0, physics.torsion * physics.natural_twist)
    strains.add_gradient(0.0, physics.torsion, natural, kin, grad, kin.frames)


@inlined
def add_hessian(physics, kin, q, b, psi, tension, hess):
    """Add its second derivatives."""
    natural = (0.0, 0.0, physics.torsion * physics.natural_twist)
    strains.add_hessian(0.0, physics.torsion, natural, kin, hess, kin.frames)
