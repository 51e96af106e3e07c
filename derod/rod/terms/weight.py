"""The weight of the drop, along -y (equa:cequivient-de-la-goutte, equa:saut_global).

    E_weight = W y_C

It pulls on the drop's centre alone; the menisci and the wall hand it on to the rod, whose force n
differs between the two ends by W. The turn about the clamp axis is no longer neutral.
"""

from __future__ import annotations

from derod.algebra.jit import inlined
from derod.rod.unknowns import X_C


@inlined
def energy(physics, kin, q, b, psi):
    """Return W y_C, K/D."""
    return physics.weight * b[X_C + len(physics.axis) - 2]


@inlined
def add_gradient(physics, kin, q, b, psi, tension, grad):
    """Add the force on the drop's centre."""
    grad.border[X_C + len(physics.axis) - 2] += physics.weight


@inlined
def add_hessian(physics, kin, q, b, psi, tension, hess):
    """Add nothing: the energy is linear."""
