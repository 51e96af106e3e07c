"""The drop's place along the rod is pinned: the menisci are mirror places.

    eta (s_A + s_B - l)

Sliding the drop along the rod costs nothing but exp(-sqrt(t) outer length), less than rounding. eta is the
force that the pin takes, zero wherever the state is symmetric.
"""

from __future__ import annotations

from derod.algebra.jit import inlined
from derod.rod.unknowns import ETA, S_A, S_B


@inlined
def add_gradient(physics, kin, q, b, psi, tension, grad):
    """Add eta to both menisci, and the constraint."""
    eta = ETA + len(physics.axis)
    grad.border[S_A] += b[eta]
    grad.border[S_B] += b[eta]
    grad.border[eta] += b[S_A] + b[S_B] - physics.length


@inlined
def add_hessian(physics, kin, q, b, psi, tension, hess):
    """Add the constraint's row."""
    eta = ETA + len(physics.axis)
    for s in range(2):
        hess.border[s, eta] += 1.0
        hess.border[eta, s] += 1.0
