"""A first state: the straight rod, bent a little inside the drop, in its plane."""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.optimize import brentq

from derod.equilibrium.system import System
from derod.rod.arrays import new_q
from derod.rod.state import State
from derod.rod.unknowns import ANGLE, BORDER, ETA, F_A, REFERENCE, S_A, S_B, X_C

BUMP_WIDTH = 0.35  # D, of the odd tangent angle's bump


def bent_guess(system: System, physics: Any, end_shortening: float, side: float = 1.0) -> State:
    """Return a planar, inextensible guess with the given end-shortening (D); not an equilibrium.

    The tangent's angle is an odd bump about the drop's centre, scaled to use up the end-shortening; ``side``
    is 1 or -1, the way it bends in y. ``physics`` are the constants it shall be settled with.
    """
    d = system.dimension
    state = State(new_q(system.edges, physics), np.zeros(BORDER + d), 0.0, end_shortening, physics)
    if physics.drop:
        wetted = min(1 + end_shortening, 0.5 * (1 + physics.length))
        middle = 0.5 * physics.length
        state.b[S_A], state.b[S_B] = middle - 0.5 * wetted, middle + 0.5 * wetted
    rest = system.rest_lengths(state)
    nodes = system.arc_length(state)
    place = 0.5 * (nodes[1:] + nodes[:-1]) - 0.5 * physics.length
    if physics.drop:
        place /= BUMP_WIDTH
        shape = place * np.exp(-0.5 * place**2)
    else:  # the clamped rod's first buckling mode
        shape = np.sin(2 * np.pi * place / physics.length)
    amplitude = brentq(
        lambda a: np.sum(rest * (1 - np.cos(a * shape))) - end_shortening, 0.0, np.pi
    )
    state.q[1:, d - 1] = np.cumsum(rest * np.cos(amplitude * shape))
    state.q[1:, d - 2] = side * np.cumsum(rest * np.sin(amplitude * shape))
    state.q[-1, d - 2] = 0.0
    state.clamp_at(end_shortening)
    if state.width > d + 1:
        turn_directors(state, rest, nodes)
    if not physics.drop:
        state.q[1:, d] = -4 * np.pi**2 / physics.length**2
        return state
    kin = system.room.kin
    tension = 0.2 * physics.capillary_force
    state.q[1:, d] = tension
    state.q[1 + kin.node_a : 1 + kin.node_b, d] = tension - physics.capillary_force
    menisci = state.q[[kin.node_a, kin.node_b], :d]
    state.b[X_C : F_A + d] = menisci.mean(axis=0)
    state.b[F_A + d : ETA + d] = physics.capillary_force
    return state


def turn_directors(state: State, rest: np.ndarray, nodes: np.ndarray) -> None:
    """Twist the section uniformly from one clamp's director to the other's; the rod lies in the y-z plane.

    Angles are counted from e_x, which a plane carries along.
    """
    middle = 0.5 * (nodes[1:] + nodes[:-1]) / nodes[-1]
    start, end = state.physics.director_start, state.physics.director_end
    state.q[1:, ANGLE] = start + (end - start) * middle
    state.q[1:, REFERENCE : REFERENCE + 3] = np.diff(state.q[:, :3], axis=0) / rest[:, None]
    state.q[1:, REFERENCE + 3 :] = 1.0, 0.0, 0.0
