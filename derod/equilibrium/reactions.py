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
from derod.rod.arrays import Kinematics
from derod.rod.state import State, in_space
from derod.rod.terms.twist import twisting_moment


@dataclass(frozen=True, slots=True)
class Reactions:
    """Internal forces n (K/D^2) and moments m (K/D) of the rod at s = 0 and s = l, in space."""

    start_force: np.ndarray  # (3,)
    end_force: np.ndarray  # (3,)
    start_moment: np.ndarray  # (3,)
    end_moment: np.ndarray  # (3,)
    twisting_moment: float  # m_3, uniform; of a section with directions that at s = l


def reactions(system: System, state: State) -> Reactions:
    """Return what the clamps hold at a settled state whose ``gradient`` was taken last."""
    d, room, physics = system.dimension, system.room, state.physics
    start, end = in_space(-room.r[0, :d]), in_space(room.r[-1, :d])
    end[2] += physics.end_tension
    moment = float(twisting_moment(physics, state.holonomy)) if d == 3 else 0.0
    x, y = clamp_slope(system, 0, moment)
    start_moment = np.array([y, -x, moment])  # -e_z x dL/dc
    x, y = clamp_slope(system, -1, moment)
    end_moment = np.array([-y, x, moment])
    if room.kin.frames is not None:  # what turns a clamp's whole frame
        start_moment -= body_moment(room.kin, 0)
        end_moment += body_moment(room.kin, -1)
        moment = float(end_moment[2])
    return Reactions(start, end, start_moment, end_moment, moment)


def body_moment(kin: Kinematics, edge: int) -> np.ndarray:
    """Return the derivative by a rotation of an edge's frame, (3,), K/D, of the terms that know it."""
    assert kin.frames is not None
    axes = kin.frames.first[:, edge], kin.frames.second[:, edge], kin.tangent[:, edge]
    return np.asarray(np.array(axes).T @ kin.frames.moment[edge])


def clamp_slope(system: System, side: int, moment: float) -> tuple[float, float]:
    """Return dL/dc across the axis, by the tangent c of the clamp at the start (0) or the end (-1).

    Written in numbers: numpy's calls on three of them would cost a tenth of a push.
    """
    kin = system.room.kin
    vertex, edge, beyond = (0, 1, 2) if side == 0 else (-1, -2, -3)
    w, rest = float(kin.weight[vertex]), float(kin.rest[edge])
    bending = w + float(system.room.tension[edge]) * rest**3 * w * w / 12
    turning = bending * float(kin.turn_slope[vertex])
    t = kin.tangent[:, edge].tolist()
    difference = kin.difference[:, edge].tolist()
    y = rest / 3 * w * difference[-2] - turning * t[-2]
    x = rest / 3 * w * difference[0] - turning * t[0] if len(t) == 3 else 0.0
    if moment != 0.0:
        inverse = 1 / (2 - float(kin.fall[vertex]))
        normal, o = kin.normal[:, vertex].tolist(), kin.tangent[:, beyond].tolist()
        a, b = (t, o) if side == 0 else (o, t)
        x -= moment * (0.125 * (a[1] * b[2] - a[2] * b[1]) - inverse * normal[0])
        y -= moment * (0.125 * (a[2] * b[0] - a[0] * b[2]) - inverse * normal[1])
    return x, y
