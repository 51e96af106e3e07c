"""What is computed from a recorded increment: curvature, moment, directors, the wall's pressure."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from derod.record import profiles as fields
from derod.record.geometry import MaterialFrame, material_frame
from derod.record.sections import section_frame, section_moment

if TYPE_CHECKING:
    from derod.record.run import BaseRun


def curvature(run: BaseRun, i: int) -> np.ndarray:
    """See ``BaseRun.curvature``."""
    return fields.curvature(run.positions(i), run.arc_length(i))


def directors(run: BaseRun, i: int) -> MaterialFrame:
    """See ``BaseRun.directors``."""
    frame = run.edge_frame(i)
    if frame is not None:
        return section_frame(run.positions(i), run.arc_length(i), frame, run.scene)
    return material_frame(run.positions(i), run.arc_length(i), twist(run, i))


def twist(run: BaseRun, i: int) -> float:
    """u3 = (R - psi)/l of increment ``i``, the same all along the rod, rad/D."""
    row = run.table[i]
    return float((row["end_rotation"] - row["holonomy"]) / run.scene.rod.length)


def moment(run: BaseRun, i: int) -> np.ndarray:
    """See ``BaseRun.moment``."""
    rod = run.scene.rod
    frame = run.edge_frame(i)
    if frame is not None:
        return section_moment(run.positions(i), run.arc_length(i), frame, run.scene)
    bend = fields.curvature_vector(run.positions(i), run.arc_length(i))
    return np.asarray(rod.bending * bend + rod.twisting * twist(run, i) * directors(run, i).d3)


def wall_pressure(run: BaseRun, i: int) -> np.ndarray:
    """See ``BaseRun.wall_pressure``."""
    row, s = run.table[i], run.arc_length(i)
    if run.scene.drop is None:
        return np.zeros(len(s))
    inside = fields.wetted(s, row["meniscus_a"], row["meniscus_b"])
    return np.where(inside, fields.wall_push(run.positions(i), run.drop_center(i), run.scene), 0.0)
