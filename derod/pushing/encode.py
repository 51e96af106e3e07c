"""Between a state (kernel units, K = 1) and the frame that is recorded (K0 units), both ways.

The push always goes on from what was recorded, so that a resumed run follows the same numbers.
"""

from __future__ import annotations

import numpy as np

from derod.equilibrium.measured import Measured
from derod.equilibrium.system import System
from derod.pushing.columns import Settled
from derod.pushing.controls import CONTROLS
from derod.pushing.frames import Frame
from derod.pushing.rows import ALL, ROW
from derod.rod.arrays import new_q
from derod.rod.state import State
from derod.rod.unknowns import ANGLE, BORDER, F_A, S_A, S_B, X_C


def encode(system: System, here: Measured, settled: Settled) -> Frame:
    """Return the frame of a settled state, with what was measured there."""
    unit, state = system.bending, here.state
    values = [column.value(here, settled) for column in ALL]
    if unit != 1:
        for k, column in enumerate(ALL):
            if column.power:
                values[k] *= unit**column.power
    row = np.array([tuple(values)], ROW)[0]
    return Frame(
        row,
        state.positions,
        here.arc_length,
        state.drop_center if system.physics.drop else np.full(3, np.nan),
        state.edge_tension * unit,
        state.edge_frame,
    )


def decode(system: System, frame: Frame, *, slides: bool = False) -> State:
    """Return the state of a recorded frame; ``slides`` tells whether its end was under a dead load."""
    d, unit = system.dimension, system.bending
    row = frame.row
    q = new_q(system.edges, system.physics)
    q[:, :d] = frame.positions[:, 3 - d :]
    q[1:, d] = frame.edge_tension / unit
    if frame.edge_frame is not None:
        q[1:, ANGLE:] = frame.edge_frame
    b = np.zeros(BORDER + d)
    if system.physics.drop:
        b[S_A], b[S_B] = row["meniscus_a"], row["meniscus_b"]
        b[X_C : F_A + d] = frame.drop_center[3 - d :]
        b[F_A + d :] = row["force_a"] / unit, row["force_b"] / unit, row["slide_force"] / unit
    physics = system.physics._replace(slides=slides)
    state = State(q, b, float(row["holonomy"]), float(row["end_shortening"]), physics)
    for name, control in CONTROLS.items():
        held = name == "end_shortening" or (name == "end_tension" and not slides)
        if not held and np.isfinite(row[name]):  # older runs have no columns of some constants
            control.set(state, float(row[name]) / unit**control.power)
    if not slides:
        state.physics = state.physics._replace(end_tension=0.0)
    return state
