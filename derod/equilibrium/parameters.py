"""Constants that no push changes, and how a settled state depends on each, the state itself held.

``derod.pushing.controls`` has what a push may change. Here are the rest: the wall's softness rho, the
torsional stiffness k3 and the length l. A ``Partial`` holds derivatives by one parameter p of the Lagrangian
L (``rod.assembly``) and of its gradient, the residual R, in the rod's units (K = 1).
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from derod.equilibrium.control import Control
from derod.rod import assembly
from derod.rod.state import State
from derod.rod.terms.twist import twisting_moment
from derod.rod.terms.wall import CORE
from derod.rod.unknowns import ETA, MOMENT, S_A, S_B, X_C

if TYPE_CHECKING:
    from derod.equilibrium.measured import Measured
    from derod.equilibrium.system import System


class Partial(NamedTuple):
    """Derivatives by a parameter p, the unknowns held."""

    column: np.ndarray  # (N, d+1) -dR/dp, rows of the nodes 1 ... N; the end clamp held
    border: np.ndarray  # and of the border's rows
    potential: float  # dL/dp, the end moving with p
    tension: float = 0.0  # dR/dp in the row of z_N, the end held
    end: float = 0.0  # dz_N/dp, as the clamp moves


def of_control(control: Control, system: System, here: Measured) -> Partial:
    """Return the partial derivatives by a control at the state measured last."""
    potential, end = control.conjugate(here), control.moves_end()
    if end:  # moving the clamp is all it does
        return Partial(*system.empty_column(), potential, end=end)
    return Partial(*control.column(system, here.state), potential)


def wall_softness(system: System, state: State) -> Partial:
    """Return the derivatives by rho of the integral of v0 / (1 + rho - 2 r).

    v_rho = -v0 / gap^2, and by w = r^2 it is -4 v0 / gap^3 dr/dw; r is the distance with the cone smoothed
    (``rod.terms.wall``).
    """
    physics, kin, d = state.physics, system.room.kin, state.dimension
    column, border = system.empty_column()
    nodes = slice(kin.node_a, kin.node_b + 1)
    x = state.q[nodes, :d] - state.b[X_C : X_C + d]
    square = np.sum(x * x, axis=1)
    y = square / CORE**2
    near = y < 1
    outer = np.sqrt(np.where(near, 1.0, square))
    r = np.where(near, CORE * (0.375 + 0.75 * y - 0.125 * y * y), outer)
    slope = np.where(near, (0.75 - 0.25 * y) / CORE, 0.5 / outer)
    inverse = 1 / (1 + physics.wall_softness - 2 * r)
    wetted = state.b[S_B] - state.b[S_A]
    mean = float(np.sum(kin.share[nodes] * -physics.wall_strength * inverse**2))
    push = 2 * wetted * kin.share[nodes] * -4 * physics.wall_strength * inverse**3 * slope
    force = push[:, None] * x
    column[kin.node_a - 1 : kin.node_b, :d] = -force
    border[S_A], border[S_B] = mean, -mean
    border[X_C : X_C + d] = force.sum(axis=0)
    return Partial(column, border, wetted * mean)


def twisting(system: System, state: State) -> Partial:
    """Return the derivatives by k3 of k3 (R - psi)^2 / (2 l): (R - psi)/k3 in the moment's row."""
    column, border = system.empty_column()
    turn = state.physics.end_rotation - state.holonomy
    if state.physics.twisting > 0:
        border[MOMENT + state.dimension] = turn / state.physics.twisting
    return Partial(column, border, 0.5 * turn**2 / state.physics.length)


def length(system: System, state: State) -> Partial:
    """Return the derivatives by l, at the state whose ``gradient`` was taken last.

    l enters by the rest lengths beyond s_B, functions of l - s_B, by the pin s_A + s_B = l, by the twist,
    and by the end clamp at l - delta. The Hessian's kernels derive by s_A and s_B through the rest lengths'
    slopes alone: given those by l in the slot of s_B, and those by s_B within the drop in that of s_A,
    they fill the column of l. The matrix has to be filled again afterwards.
    """
    room, physics, d = system.room, state.physics, state.dimension
    kin, hess = room.kin, room.hess
    column, border = system.empty_column()
    slope, by_length = kin.slope.copy(), np.zeros_like(kin.rest)
    if physics.drop:
        outer = slice(kin.node_b + 1, -1)
        by_length[outer] = -slope[1, outer]
        kin.slope[0] = slope[1] + by_length  # of s_B, what lies within the drop
    else:
        by_length[1:-1] = kin.rest[1:-1] / physics.length
        kin.slope[0] = 0.0
    kin.slope[1] = by_length
    potential = float(room.grad.rest @ by_length)
    end_pull = float(room.r[-1, d - 1])
    assembly.hessian(physics, state.q, state.b, state.holonomy, room)
    kin.slope[:] = slope
    by_edge, tension_row = hess.edge_menisci[1], hess.constraint_menisci[1]
    column[:-1, :d] = by_edge[2:-1] - by_edge[1:-2]
    column[:, d] = -tension_row[1:-1]
    if physics.slides:
        column[-1, d - 1] = -by_edge[-2, d - 1]
    if physics.drop:
        inside, own = hess.border[0, 1], hess.border[1, 1]
        border[S_A], border[S_B] = inside, own - inside
        border[ETA + d] = 1.0
        potential -= state.slide_force
    if d == 3 and physics.twisting > 0:
        moment = twisting_moment(physics, state.holonomy)
        border[MOMENT + 3] = -moment / physics.twisting
        potential -= 0.5 * moment * (physics.end_rotation - state.holonomy) / physics.length
    if physics.slides:  # of the dead load's T (l - z_N), z_N an unknown
        return Partial(column, border, potential + physics.end_tension)
    return Partial(column, border, potential + end_pull, float(by_edge[-2, d - 1]), end=1.0)


CONSTANTS: dict[str, Callable[[System, State], Partial]] = {
    "wall_softness": wall_softness,
    "twisting": twisting,
    "length": length,
}
"""By the scene's key."""
