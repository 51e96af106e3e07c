"""What the clamps hold: force and moment at both ends (sys:kirchhoff-equilibrium).

The clamps' forces are the residual's rows of the first and the last node. Their bending moments are the
virtual work of turning a clamp's tangent c: c x dE/dc, of the terms that know it,

    sum C_i phi_i^2   (``terms.bending``, the vertex beside the clamp)
    (l_e/12) |d|^2    (``terms.defect``, the edge beside it)
    -m_3 psi          (``terms.twist``, its corner)

and the twisting moment m_3 acts along c. All are exact derivatives of the discrete energy: forces and moments
balance to rounding (equa:saut_global), whatever the mesh.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from derod.equilibrium.system import System
from derod.rod.state import State, in_space
from derod.rod.terms.twist import twisting_moment


@dataclass(frozen=True, slots=True)
class Reactions:
    """Internal forces n (K/D^2) and moments m (K/D) of the rod at s = 0 and s = l, in space."""

    start_force: np.ndarray  # (3,)
    end_force: np.ndarray  # (3,)
    start_moment: np.ndarray  # (3,)
    end_moment: np.ndarray  # (3,)
    twisting_moment: float  # m_3, uniform


def reactions(system: System, state: State) -> Reactions:
    """Return what the clamps hold at a settled state whose ``gradient`` was taken last."""
    d, room, physics = system.dimension, system.room, state.physics
    start, end = in_space(-room.r[0, :d]), in_space(room.r[-1, :d])
    end[2] += physics.end_tension
    moment = float(twisting_moment(physics, state.holonomy)) if d == 3 else 0.0
    axis = np.array([0.0, 0.0, 1.0])
    moments = []
    for side in (0, -1):
        slope = clamp_slope(system, state, side, moment)
        turned = np.cross(axis, slope)
        moments.append((turned if side == -1 else -turned) + moment * axis)
    return Reactions(start, end, moments[0], moments[1], moment)


def clamp_slope(system: System, state: State, side: int, moment: float) -> np.ndarray:
    """Return dL/dc, (3,), by the tangent c of the clamp at the start (0) or the end (-1)."""
    kin = system.room.kin
    vertex, edge, next_one = (0, 1, 2) if side == 0 else (-1, -2, -3)
    w, rest, t = kin.weight[vertex], kin.rest[edge], kin.tangent[:, edge]
    bending = w + system.room.tension[edge] * rest**3 * w * w / 12
    slope = in_space(rest / 3 * w * kin.difference[:, edge] - bending * kin.turn_slope[vertex] * t)
    if moment != 0.0:
        polygon = kin.normal[:, vertex] / (2 - kin.fall[vertex])
        beyond = kin.tangent[:, next_one]
        corner = np.cross(t, beyond) if side == 0 else np.cross(beyond, t)
        slope -= moment * (0.125 * corner - polygon)
    return slope
