"""The one place that names every term: energies, residual, and the bordered band matrix.

The Lagrangian is E_tot plus the constraints. Its gradient in the layout of the state is the residual
(``r`` like q, ``rb`` like b). Its Hessian is a band of half width 4d+2 over the unknowns of q[1:],
bordered by b and, where there is twist, by two more: the twisting moment (which makes the dense
k3/l grad psi grad psi a row) and the turn of the coil about the clamp axis (a neutral mode, deflated).
Row N of q is prescribed by the clamp: its positions keep unit rows.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from derod.algebra.copying import copy_vector
from derod.algebra.jit import inlined, kernel
from derod.rod import layout
from derod.rod.constraints.stretch import add_stretch, add_stretch_gradient, add_stretch_hessian
from derod.rod.kinematics import measure
from derod.rod.layout import S_A, S_B, X_C, Gradient, Hessian, Kinematics, Mesh, Physics
from derod.rod.terms.bending import (
    add_bending_hessian,
    bending_energy,
    fill_bending_gradient,
    fill_turns,
)
from derod.rod.terms.defect import add_defect_gradient, add_defect_hessian, defect_energy
from derod.rod.terms.menisci import add_menisci_gradient, add_menisci_hessian, capillary_energy
from derod.rod.terms.twist import add_twist_gradient, add_twist_hessian, holonomy, twisting_moment
from derod.rod.terms.wall import add_wall_gradient, add_wall_hessian, wall_energy

DEFLATION = 1e-4  # keeps the turn's row regular where the rod is straight


class Linear(NamedTuple):
    """A bordered band matrix [[K, B], [B^T, C]]; row-major lower diagonals of K, padded below."""

    band: np.ndarray  # ((d+1)N + w, w+1), band[j, k] = K[j+k, j]
    border: np.ndarray  # ((d+1)N + w, m)
    corner: np.ndarray  # (m, m)


class Room(NamedTuple):
    """Arrays the assembly works in, made once a mesh."""

    kin: Kinematics
    grad: Gradient
    hess: Hessian
    tension: np.ndarray  # (N+2,) by edge
    r: np.ndarray  # (N+1, d+1) residual by q
    rb: np.ndarray  # (d+5,) residual by b
    linear: Linear


def half_width(d: int) -> int:
    """Return the half width of the band in d dimensions."""
    return 4 * d + 2


def border_count(d: int) -> int:
    """Return the number of border rows in d dimensions."""
    return d + 5 + (2 if d == 3 else 0)


def new_linear(edges: int, d: int) -> Linear:
    """Return room for a bordered band matrix."""
    w, m = half_width(d), border_count(d)
    rows = (d + 1) * edges + w
    return Linear(np.zeros((rows, w + 1)), np.zeros((rows, m)), np.zeros((m, m)))


def new_room(mesh: Mesh, physics: Physics) -> Room:
    """Return room for assembling a mesh."""
    edges, d = mesh.edges, len(physics.axis)
    return Room(
        layout.new_kinematics(mesh, physics),
        layout.new_gradient(edges, d),
        layout.new_hessian(edges, d),
        np.zeros(edges + 2),
        np.zeros((edges + 1, d + 1)),
        np.zeros(d + 5),
        new_linear(edges, d),
    )


@inlined
def energies(physics, q, b, psi, end_rotation, room):
    """Return E_bend, E_twist, E_wall, E_capillary of a state, K0/D; ``room.kin`` must be measured."""
    moment = twisting_moment(physics, end_rotation, psi)
    twist = 0.5 * moment * (end_rotation - psi)
    return (
        bending_energy(room.kin) + defect_energy(physics.axis, room.kin),
        twist if len(physics.axis) == 3 else 0.0,
        wall_energy(physics, room.kin, q, b),
        capillary_energy(physics, b),
    )


@inlined
def total_energy(physics, q, b, psi, end_rotation, room):
    """Return E_tot, the sum of all ``energies``."""
    total = 0.0
    for part in energies(physics, q, b, psi, end_rotation, room):
        total += part
    return total


@kernel
def measured_energies(physics, mesh, q, b, psi, end_rotation, room):
    """Measure a state and return its ``energies``."""
    measure(physics, mesh, q, b, room.kin)
    return energies(physics, q, b, psi, end_rotation, room)


@kernel
def gradient(physics, mesh, q, b, psi, end_rotation, room):
    """Fill ``room.r``, ``room.rb`` at the state; return (psi followed, finite?).

    The rows of r for the clamped ends hold the clamps' reactions: r[N, :d] is dL/dx_N, whose axial
    part is the end tension t.
    """
    sound = constraints(physics, mesh, q, b, room)
    psi, finite = forces(physics, q, b, psi, end_rotation, room)
    return psi, sound and finite


@inlined
def constraints(physics, mesh, q, b, room):
    """Measure the rod and fill the stretch constraints; return False where an edge has no length."""
    sound = measure(physics, mesh, q, b, room.kin)
    fill_turns(room.kin, room.grad)
    add_stretch(room.kin, room.grad)
    return sound


@inlined
def forces(physics, q, b, psi, end_rotation, room):
    """Do what ``gradient`` does, after ``constraints``."""
    d = len(physics.axis)
    kin, grad, tension = room.kin, room.grad, room.tension
    n = q.shape[0] - 1
    for e in range(1, n + 1):
        tension[e] = q[e, d]
    grad.node[:] = 0.0
    grad.border[:] = 0.0
    fill_bending_gradient(physics.axis, kin, tension, grad)  # the first: it sets what others add to
    add_defect_gradient(physics.axis, kin, grad)
    add_stretch_gradient(kin, tension, grad)
    if physics.drop:
        add_wall_gradient(physics, kin, q, b, grad)
        add_menisci_gradient(physics, kin, q, b, grad)
    turn_into_edges(physics.axis, kin, grad)
    if d == 3:
        psi = holonomy(kin, psi, grad)
        add_twist_gradient(kin, twisting_moment(physics, end_rotation, psi), grad)
    for k in range(d):
        for i in range(n + 1):
            room.r[i, k] = grad.node[i, k] + grad.edge[k, i] - grad.edge[k, i + 1]
    total = 0.0
    for i in range(n + 1):
        room.r[i, d] = grad.constraint[i]
        total += room.r[i, 0] + room.r[i, 1] + room.r[i, d - 1] + room.r[i, d]
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
def turn_into_edges(axis, kin, grad):
    """Turn derivatives by directions and duals into those by edges and rest lengths.

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
            grad.edge[k, e] = across - dot[e] * kin.tangent[k, e]
    for e in range(1, n + 1):
        grad.rest[e] += grad.dual[e - 1] + grad.dual[e]


@kernel
def hessian(physics, q, b, psi, end_rotation, room):
    """Fill ``room.linear`` at the state whose ``gradient`` was taken last."""
    hess, kin = room.hess, room.kin
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
        for k in range(len(physics.axis)):
            hess.tangent[e, k] = kin.tangent[k, e]
            hess.difference[e, k] = kin.difference[k, e]
    add_bending_hessian(physics, kin, room.tension, hess)
    add_defect_hessian(physics.axis, kin, hess)
    add_stretch_hessian(physics, kin, room.tension, hess)
    if physics.drop:
        add_wall_hessian(physics, kin, q, b, hess)
        add_menisci_hessian(physics, kin, q, b, hess)
    else:  # idle unknowns, and idle constraints with the sign of their kind
        d = len(physics.axis)
        for k in range(d + 5):
            hess.border[k, k] = 1.0 if k < X_C + d else -1.0
    for s in range(2):
        for e in range(kin.rest.size):
            hess.border[s, s] += room.grad.rest[e] * kin.curve[s, e]
    if len(physics.axis) == 3:
        add_twist_hessian(kin, twisting_moment(physics, end_rotation, psi), hess)
    fill_band(physics, hess, room.linear.band)
    fill_border(physics, q, b, room)


@inlined
def fill_band(physics, hess, band):
    """Turn the edge form into the lower diagonals of K, unknown (d+1)(i-1)+k being q[i, k]."""
    d = len(physics.axis)
    n = hess.node.shape[0] - 1
    band[:] = 0.0
    for i in range(1, n):  # free nodes
        for k in range(d):
            column = (d + 1) * (i - 1) + k
            for m in range(d):
                if m >= k:
                    band[column, m - k] = (
                        hess.edge[i, m, k]
                        + hess.edge[i + 1, m, k]
                        - hess.vertex[i, m, k]
                        - hess.vertex[i, k, m]
                        + hess.node[i, m, k]
                    )
                if i + 1 < n:
                    band[column, d + 1 + m - k] = (
                        -hess.edge[i + 1, m, k]
                        + hess.vertex[i, k, m]
                        + hess.vertex[i + 1, k, m]
                        - hess.skip[i + 1, k, m]
                    )
                if i + 2 < n:
                    band[column, 2 * (d + 1) + m - k] = (
                        -hess.vertex[i + 1, k, m] + hess.skip[i + 1, k, m] + hess.skip[i + 2, k, m]
                    )
                if i + 3 < n:
                    band[column, 3 * (d + 1) + m - k] = -hess.skip[i + 2, k, m]
    for k in range(d):
        band[(d + 1) * (n - 1) + k, 0] = 1.0
    for e in range(1, n + 1):  # tension rows
        row = (d + 1) * (e - 1) + d
        for node in range(max(1, e - 2), min(n - 1, e + 1) + 1):
            slot = node - e + 2  # x_{e-2} ... x_{e+1}, by the edges e-1, e, e+1
            for k in range(d):
                value = 0.0
                if slot >= 1:
                    value += hess.constraint[e, slot - 1, k]
                if slot <= 2:
                    value -= hess.constraint[e, slot, k]
                column = (d + 1) * (node - 1) + k
                band[min(row, column), abs(row - column)] = value


@inlined
def fill_border(physics, q, b, room):
    """Fill the border columns and the corner."""
    d = len(physics.axis)
    hess, kin = room.hess, room.kin
    border, corner = room.linear.border, room.linear.corner
    n = q.shape[0] - 1
    border[:] = 0.0
    corner[:] = 0.0
    for k in range(d + 5):
        for m in range(d + 5):
            corner[k, m] = hess.border[k, m]
    for i in range(1, n + 1):
        for s in range(2):
            if i < n:
                for k in range(d):
                    border[(d + 1) * (i - 1) + k, s] = (
                        hess.edge_menisci[s, i, k]
                        - hess.edge_menisci[s, i + 1, k]
                        + hess.node_menisci[s, i, k]
                    )
            border[(d + 1) * (i - 1) + d, s] = hess.constraint_menisci[s, i]
    for i in range(kin.node_a, kin.node_b + 1):  # moving the drop is moving the nodes back
        for k in range(d):
            row = (d + 1) * (i - 1) + k
            for m in range(d):
                border[row, X_C + m] = -hess.node[i, k, m]
                corner[X_C + k, X_C + m] += hess.node[i, k, m]
            for s in range(2):
                corner[s, X_C + k] -= hess.node_menisci[s, i, k]
                corner[X_C + k, s] -= hess.node_menisci[s, i, k]
    for side in range(2 if physics.drop else 0):
        i = kin.node_a if side == 0 else kin.node_b
        for k in range(d):
            border[(d + 1) * (i - 1) + k, X_C + d + side] = 2 * (q[i, k] - b[X_C + k])
    if d == 3:
        fill_twist_and_turn(physics, kin, room.grad, q, b, border, corner)


@inlined
def fill_twist_and_turn(physics, kin, grad, q, b, border, corner):
    """Fill the last two border rows: the twisting moment and the turn about the clamp axis."""
    moment, turn = 8, 9
    twists = physics.twisting > 0
    corner[moment, moment] = -physics.length / physics.twisting if twists else -1.0
    square = 0.0
    for i in range(1, q.shape[0] - 1):
        row = 4 * (i - 1)
        for k in range(3):
            if twists:
                border[row + k, moment] = grad.holonomy[k, i] - grad.holonomy[k, i + 1]
        dual = 0.5 * (kin.rest[i] + kin.rest[i + 1])
        border[row, turn] = -dual * q[i, 1]
        border[row + 1, turn] = dual * q[i, 0]
        square += dual * (q[i, 0] ** 2 + q[i, 1] ** 2)
    corner[X_C, turn] = -b[X_C + 1]
    corner[X_C + 1, turn] = b[X_C]
    corner[turn, X_C] = corner[X_C, turn]
    corner[turn, X_C + 1] = corner[X_C + 1, turn]
    square += b[X_C] ** 2 + b[X_C + 1] ** 2
    corner[turn, turn] = -(square + DEFLATION)
