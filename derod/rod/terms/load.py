"""A dead load on the end clamp: it slides along the axis under the pull T (``clamps.end_tension``).

    E_load = T (l - z_N)

It is the potential of what pulls, no energy of the rod and the drop: E_tot leaves it out, and what falls
in a relaxation is the sum of both. T is 0 where the end-shortening is held.
"""

from __future__ import annotations

from derod.algebra.jit import inlined


@inlined
def energy(physics, kin, q, b, psi):
    """Return T (l - z_N), K/D."""
    return physics.end_tension * (physics.length - q[q.shape[0] - 1, len(physics.axis) - 1])


@inlined
def add_gradient(physics, kin, q, b, psi, tension, grad):
    """Add the pull on the last node."""
    grad.node[q.shape[0] - 1, len(physics.axis) - 1] -= physics.end_tension


@inlined
def add_hessian(physics, kin, q, b, psi, tension, hess):
    """Add nothing: the potential is linear."""
