"""Modes in rerun: the rod of an increment, and on top of it how each mode moves it, to and fro.

The timeline ``phase`` runs once round; each mode is an entity of its own, to be shown or hidden, coloured
by how far it moves the rod. On the timeline ``mode`` its eigenvalue is a point of a series.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from derod.record.run import BaseRun
from derod.views.stream.drawing import Batch, Column, draw_shapes
from derod.views.stream.replay import PATH_COLORS

if TYPE_CHECKING:
    from derod.record.modes import Modes

SWING = 0.12  # D that the largest component moves to each side
PHASES = 32
LINE = 0.012  # D, radius


def mode_strips(x: np.ndarray, shape: np.ndarray) -> np.ndarray:
    """The rod (N+1, 3) moved along a mode through one period, (PHASES, N+1, 3)."""
    swing = SWING * np.sin(2 * math.pi * np.arange(PHASES) / PHASES)
    return np.asarray(x + swing[:, None, None] * shape, dtype=np.float32)


def send_modes(recording: Any, run: BaseRun, i: int, found: Modes, color: str) -> None:
    """Send an increment and its modes."""
    import rerun as rr

    from derod.views.stream.stage import Stage, send_column

    stage = Stage(recording, run.scene, color, live=False)
    batch = Batch.of([run.frame_at(i)])
    stage.send(draw_shapes(batch, run.scene, color), batch.rows)
    times = [rr.TimeColumn("phase", sequence=np.arange(PHASES))]
    for k, value in enumerate(found.eigenvalues):
        tint = PATH_COLORS[k % len(PATH_COLORS)]
        words = " ".join(word for word in (found.flip[k], found.plane[k]) if word)
        name = f"mode {k + 1}: {value:.4g} K0/D⁴ {words}".strip()
        entity = f"world/modes/{k + 1}"
        look = rr.LineStrips3D.from_fields(
            colors=[tint], radii=LINE, labels=[name], show_labels=k == 0
        )
        recording.log(entity, look, static=True)
        strips = [[line] for line in mode_strips(run.positions(i), found.shapes[k])]
        send_column(recording, Column(entity, "LineStrips3D", {"strips": strips}), times)
    recording.log(
        "plots/eigenvalues", rr.SeriesPoints(names="eigenvalue, K0/D⁴", marker_sizes=6), static=True
    )
    send_column(
        recording,
        Column("plots/eigenvalues", "Scalars", {"scalars": list(found.eigenvalues[:, None])}),
        [rr.TimeColumn("mode", sequence=np.arange(1, len(found) + 1))],
    )
