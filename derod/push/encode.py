"""Between a state (kernel units, K = 1) and the frame that is recorded (K0 units), both ways.

The push always goes on from what was recorded, so that a resumed run follows the same numbers.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from derod.equilibrium.stability import Equilibrium
from derod.equilibrium.system import System
from derod.push.frames import ROW, Frame
from derod.rod.layout import S_A, S_B, X_C
from derod.rod.state import State


class Settled(NamedTuple):
    """How a state was settled: what a row says beside the state itself."""

    increment: int
    segment: int
    smooth: bool
    landing: bool
    unstable_modes: int
    residual: float  # K/D^2
    work_defect: float  # K/D
    iterations: int
    next_step: float
    wall_time: float


def encode(system: System, state: State, here: Equilibrium, settled: Settled) -> Frame:
    """Return the frame of a settled state, with what was measured there."""
    unit = system.bending
    energies = here.energies
    s_a, s_b = state.menisci
    row = np.zeros(1, ROW)[0]
    for name, value in settled._asdict().items():
        row[name] = value
    row["residual"] = settled.residual * unit
    row["work_defect"] = settled.work_defect * unit
    row["converged"] = here.settled
    row["slides"] = here.slides
    row["turning_angle"] = here.turning
    row["end_shortening"] = state.end_shortening
    row["end_rotation"] = system.end_rotation
    row["end_tension"] = here.tension * unit
    row["energy_total"] = energies.total * unit
    row["energy_hat"] = (
        energies.total + system.physics.capillary_force * (state.end_shortening + 1)
    ) * unit
    row["energy_bend"] = energies.bend * unit
    row["energy_twist"] = energies.twist * unit
    row["energy_wall"] = energies.wall * unit
    row["energy_capillary"] = energies.capillary * unit
    row["wetted_length"] = s_b - s_a
    row["meniscus_a"], row["meniscus_b"] = s_a, s_b
    row["force_a"], row["force_b"] = (f * unit for f in state.forces)
    row["holonomy"] = state.holonomy
    row["slide_force"] = state.slide_force * unit
    row["wall_gap"] = here.wall_gap
    return Frame(
        row,
        state.positions,
        system.arc_length(state),
        state.drop_center if system.physics.drop else np.full(3, np.nan),
        state.edge_tension * unit,
    )


def decode(system: System, frame: Frame) -> State:
    """Return the state of a recorded frame."""
    d, unit = system.dimension, system.bending
    row = frame.row
    q = np.zeros((system.edges + 1, d + 1))
    q[:, :d] = frame.positions[:, 3 - d :]
    q[1:, d] = frame.edge_tension / unit
    b = np.zeros(d + 5)
    if not system.physics.drop:
        return State(q, b, float(row["holonomy"]), float(row["end_shortening"]))
    b[S_A], b[S_B] = row["meniscus_a"], row["meniscus_b"]
    b[X_C : X_C + d] = frame.drop_center[3 - d :]
    b[X_C + d :] = row["force_a"] / unit, row["force_b"] / unit, row["slide_force"] / unit
    return State(q, b, float(row["holonomy"]), float(row["end_shortening"]))
