"""Capillarity: the energy gained for the rod wetted (equa:energie-capillaire).

    E_capillary = -f_gamma (s_B - s_A)

Stationarity in s_A and s_B is the tension jump (sys:tension-jump).
"""

from __future__ import annotations

from derod.algebra.jit import inlined
from derod.rod.unknowns import S_A, S_B


@inlined
def energy(physics, kin, q, b, psi):
    """Return -f_gamma (s_B - s_A), K/D."""
    return -physics.capillary_force * (b[S_B] - b[S_A])


@inlined
def add_gradient(physics, kin, q, b, psi, tension, grad):
    """Add the pull on the menisci's places."""
    grad.border[S_A] += physics.capillary_force
    grad.border[S_B] -= physics.capillary_force


@inlined
def add_hessian(physics, kin, q, b, psi, tension, hess):
    """Add nothing: the energy is linear."""
