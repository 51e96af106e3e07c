"""The one place that sums every term: energies, residual, Hessian.

The Lagrangian is E_tot, and the potential of a dead load, plus the constraints. Its gradient in the layout of
the state is the residual (``r`` like q, ``rb`` like b). The lines between "terms" and "end" are written by
``python -m derod.rod.terms.writing`` from the list of terms: a flat sum compiles once and runs fastest.
"""

from __future__ import annotations

import numpy as np

from derod.algebra.copying import copy_vector
from derod.algebra.jit import inlined, kernel
from derod.rod.band import fill_band, fill_border
from derod.rod.constraints import on_sphere, pin, stretch
from derod.rod.frame_hessian import add_second, clear_second
from derod.rod.frames import add_moments, clear_forces, renew
from derod.rod.kinematics import measure

# terms: imports
from derod.rod.terms import bending, capillary, defect, load, section, torsion, twist, wall, weight

# end
from derod.rod.terms.bending import fill_turns
from derod.rod.terms.twist import holonomy
from derod.rod.unknowns import BORDER, F_A, S_A, S_B, X_C


@inlined
def energies(physics, q, b, psi, room):
    """Return the energy of every term, K/D, in the order of the list; ``room.kin`` must be measured."""
    kin = room.kin
    # terms: energy
    return (
        bending.energy(physics, kin, q, b, psi),
        defect.energy(physics, kin, q, b, psi),
        wall.energy(physics, kin, q, b, psi) if physics.drop else 0.0,
        capillary.energy(physics, kin, q, b, psi) if physics.drop else 0.0,
        weight.energy(physics, kin, q, b, psi) if physics.drop else 0.0,
        twist.energy(physics, kin, q, b, psi) if len(physics.axis) == 3 else 0.0,
        section.energy(physics, kin, q, b, psi),
        torsion.energy(physics, kin, q, b, psi),
        load.energy(physics, kin, q, b, psi),
    )
    # end


@inlined
def potential(physics, q, b, psi, room):
    """Return the sum of all ``energies``: what a relaxation lowers."""
    total = 0.0
    for part in energies(physics, q, b, psi, room):
        total += part
    return total


@kernel
def measured_energies(physics, mesh, q, b, psi, room):
    """Measure a state and return its ``energies``."""
    measure(physics, mesh, q, b, room.kin)
    return energies(physics, q, b, psi, room)


@kernel
def gradient(physics, mesh, q, b, psi, room):
    """Fill ``room.r``, ``room.rb`` at the state; return (psi followed, finite?).

    The rows of r for the clamped ends hold the clamps' reactions: r[N, :d] is dL/dx_N, whose axial
    part is the end tension t, less the dead load where the end slides.
    """
    sound = constraints(physics, mesh, q, b, room)
    psi, finite = forces(physics, q, b, psi, room)
    return psi, sound and finite


@inlined
def constraints(physics, mesh, q, b, room):
    """Measure the rod and fill the stretch constraints; return False where an edge has no length."""
    sound = measure(physics, mesh, q, b, room.kin)
    fill_turns(room.kin, room.grad)
    stretch.fill_chords(room.kin, room.grad)
    return sound


@inlined
def forces(physics, q, b, psi, room):
    """Do what ``gradient`` does, after ``constraints``."""
    d = len(physics.axis)
    kin, grad, tension = room.kin, room.grad, room.tension
    n = q.shape[0] - 1
    for e in range(1, n + 1):
        tension[e] = q[e, d]
    clear_gradient(grad)
    clear_forces(kin.frames)
    if len(physics.axis) == 3:
        psi = holonomy(kin, psi, grad)
    # terms: add_gradient
    bending.add_gradient(physics, kin, q, b, psi, tension, grad)
    defect.add_gradient(physics, kin, q, b, psi, tension, grad)
    if physics.drop:
        wall.add_gradient(physics, kin, q, b, psi, tension, grad)
    if physics.drop:
        capillary.add_gradient(physics, kin, q, b, psi, tension, grad)
    if physics.drop:
        weight.add_gradient(physics, kin, q, b, psi, tension, grad)
    if len(physics.axis) == 3:
        twist.add_gradient(physics, kin, q, b, psi, tension, grad)
    section.add_gradient(physics, kin, q, b, psi, tension, grad)
    torsion.add_gradient(physics, kin, q, b, psi, tension, grad)
    load.add_gradient(physics, kin, q, b, psi, tension, grad)
    # end
    stretch.add_gradient(physics, kin, q, b, psi, tension, grad)
    if physics.drop:
        on_sphere.add_gradient(physics, kin, q, b, psi, tension, grad)
        pin.add_gradient(physics, kin, q, b, psi, tension, grad)
    add_moments(kin, grad, room.r, kin.frames)
    turn_into_edges(physics.axis, kin, grad)
    for k in range(d):
        for i in range(n + 1):
            room.r[i, k] = grad.node[i, k] + grad.edge[k, i] - grad.edge[k, i + 1]
    total = 0.0
    for i in range(n + 1):
        room.r[i, d] = grad.constraint[i]
        for k in range(len(physics.row)):
            total += room.r[i, k]
    for i in range(kin.node_a, kin.node_b + 1):
        for k in range(d):
            grad.border[X_C + k] -= grad.node[i, k]  # moving the drop is moving the nodes back
    by_a, by_b = 0.0, 0.0
    for e in range(1, n + 1):
        by_a += grad.rest[e] * kin.slope[0, e]
        by_b += grad.rest[e] * kin.slope[1, e]
    grad.border[S_A] += by_a
    grad.border[S_B] += by_b
    copy_vector(grad.border, room.rb)
    return psi, np.isfinite(total) and np.isfinite(np.sum(room.rb))


@inlined
def clear_gradient(grad):
    """Set to zero what terms and constraints add to."""
    grad.direction[:] = 0.0
    grad.edge[:] = 0.0
    grad.node[:] = 0.0
    grad.rest[:] = 0.0
    grad.dual[:] = 0.0
    grad.border[:] = 0.0


@inlined
def turn_into_edges(axis, kin, grad):
    """Add derivatives by directions and duals to those by edges and rest lengths.

    Edges 0 and N+1, the clamps' tangents, do not move.
    """
    n = kin.rest.size - 2
    dot = grad.by_edge
    for e in range(1, n + 1):
        along = 0.0
        for k in range(len(axis)):
            along += kin.tangent[k, e] * grad.direction[k, e]
        dot[e] = along
    for e in range(1, n + 1):
        dot[e] = kin.inverse[e] * dot[e] - grad.pull[e]
    for k in range(len(axis)):
        for e in range(1, n + 1):
            across = kin.inverse[e] * grad.direction[k, e]
            grad.edge[k, e] += across - dot[e] * kin.tangent[k, e]
    for e in range(1, n + 1):
        grad.rest[e] += grad.dual[e - 1] + grad.dual[e]


@inlined
def clear_hessian(axis, kin, hess):
    """Set to zero what terms and constraints add to; lay out the tangents edge by edge."""
    hess.edge[:] = 0.0
    hess.vertex[:] = 0.0
    hess.skip[:] = 0.0
    hess.node[:] = 0.0
    hess.constraint[:] = 0.0
    hess.edge_menisci[:] = 0.0
    hess.node_menisci[:] = 0.0
    hess.constraint_menisci[:] = 0.0
    hess.border[:] = 0.0
    for e in range(kin.rest.size):
        for k in range(len(axis)):
            hess.tangent[e, k] = kin.tangent[k, e]
            hess.difference[e, k] = kin.difference[k, e]


@inlined
def hold_idle(d, hess):
    """Give idle unknowns, where there is no drop, unit rows with the sign of their kind."""
    for k in range(BORDER + d):
        hess.border[k, k] = 1.0 if k < F_A + d else -1.0


@kernel
def hessian(physics, q, b, psi, room):
    """Fill ``room.linear`` at the state whose ``gradient`` was taken last; renew its frames' references."""
    hess, kin, tension = room.hess, room.kin, room.tension
    clear_hessian(physics.axis, kin, hess)
    renew(q, kin.tangent, kin.frames)
    clear_second(kin.frames)
    # terms: add_hessian
    bending.add_hessian(physics, kin, q, b, psi, tension, hess)
    defect.add_hessian(physics, kin, q, b, psi, tension, hess)
    if physics.drop:
        wall.add_hessian(physics, kin, q, b, psi, tension, hess)
    if physics.drop:
        capillary.add_hessian(physics, kin, q, b, psi, tension, hess)
    if physics.drop:
        weight.add_hessian(physics, kin, q, b, psi, tension, hess)
    if len(physics.axis) == 3:
        twist.add_hessian(physics, kin, q, b, psi, tension, hess)
    section.add_hessian(physics, kin, q, b, psi, tension, hess)
    torsion.add_hessian(physics, kin, q, b, psi, tension, hess)
    load.add_hessian(physics, kin, q, b, psi, tension, hess)
    # end
    add_second(kin, hess, kin.frames)
    stretch.add_hessian(physics, kin, q, b, psi, tension, hess)
    if physics.drop:
        on_sphere.add_hessian(physics, kin, q, b, psi, tension, hess)
        pin.add_hessian(physics, kin, q, b, psi, tension, hess)
    else:
        hold_idle(len(physics.axis), hess)
    for s in range(2):
        for e in range(kin.rest.size):
            hess.border[s, s] += room.grad.rest[e] * kin.curve[s, e]
    fill_band(physics, hess, room.linear.band)
    fill_border(physics, q, b, turns_freely(physics), room)


@inlined
def turns_freely(physics):
    """Return whether turning the coil about the clamp axis costs nothing."""
    # terms: breaks_turn
    return physics.weight == 0.0 and physics.section == 0.0
    # end
