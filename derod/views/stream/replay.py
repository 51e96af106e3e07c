"""Run and branch files replayed: the same pictures as while they ran, sent in columns."""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from derod.record import BaseRun, open_run
from derod.views.stream.drawing import Batch, Column, draw

if TYPE_CHECKING:
    from derod.views.stream.target import Target
    from derod.views.stream.viewers import Opened

TOGETHER = 32  # frames in a column
MOST_POINTS = 150  # of a path that are drawn

PATH_COLORS = [
    (86, 180, 233), (230, 159, 0), (0, 158, 115), (204, 121, 167), (240, 228, 66), (213, 94, 0),
    (150, 150, 160), (0, 114, 178),
]  # fmt: skip


def replay_run(recording: Any, run: BaseRun, color: str) -> None:
    """Send all increments, events and the ending of a run."""
    from derod.views.stream.stage import Stage

    stage = Stage(recording, run.scene, color, live=False)
    for batch in batches(run):
        stage.send(draw(batch, run.scene, color), batch.rows)
    stage.events(run.events)
    if run.ending is not None:
        stage.ending(run.ending, max(len(run) - 1, 0))


def batches(run: BaseRun, together: int = TOGETHER) -> Iterator[Batch]:
    """The frames of a run, some at a time."""
    for first in range(0, len(run), together):
        last = min(first + together, len(run))
        yield Batch.of([run.frame_at(i) for i in range(first, last)])


def replay_branches(recording: Any, branches: Any) -> None:
    """Send all paths of a branch file (``derod.open_branches``): one entity a path.

    Its shapes are on the timeline ``point`` (their number), and those of lowest energy also on
    ``end_shortening``. Time series are cut at folds: against end-shortening a path has many values.
    """
    import rerun as rr

    from derod.views.stream.blueprint import branch_blueprint
    from derod.views.stream.legend import wall_edge
    from derod.views.stream.stage import drop_mesh, send_column

    recording.send_blueprint(branch_blueprint(list(branches)))
    recording.log("world", rr.ViewCoordinates.RIGHT_HAND_Y_UP, static=True)
    recording.log("world/drop/surface", drop_mesh(), static=True)
    for branch in list(branches.values())[:1]:  # all are of one drop
        edge = wall_edge(branch.parameters.wall_softness)
        recording.log("world/drop/edge", edge, static=True)
    for number, (name, branch) in enumerate(branches.items()):
        place = rr.escape_entity_path_part(name)
        tint = PATH_COLORS[number % len(PATH_COLORS)]
        table = branch.table
        points = np.unique(np.linspace(0, len(table) - 1, MOST_POINTS).round().astype(int))
        curve = rr.LineStrips3D.from_fields(
            colors=[tint], radii=0.012, labels=[name], show_labels=True
        )
        recording.log(f"world/branches/{place}", curve, static=True)
        lowest = points[lowest_sheet(table)[points]]
        delta = table["end_shortening"]
        for shown, time in (
            (points, rr.TimeColumn("point", sequence=points)),
            (lowest, rr.TimeColumn("end_shortening", duration=delta[lowest])),
        ):
            strips = [[_centered(branch, int(i))] for i in shown]
            column = Column(f"world/branches/{place}", "LineStrips3D", {"strips": strips})
            send_column(recording, column, [time])
        for number_of_sheet, (first, last) in enumerate(sheets(delta)):
            at = np.arange(first, last + 1)
            times = [
                rr.TimeColumn("point", sequence=at),
                rr.TimeColumn("end_shortening", duration=delta[at]),
            ]
            for quantity, symbol in (("end_tension", "tension"), ("energy_hat", "energy_hat")):
                entity = f"branches/{symbol}/{place}/{number_of_sheet}"
                look = rr.SeriesLines(names=name, colors=[tint], widths=1.5)
                recording.log(entity, look, static=True)
                values = list(table[quantity][at][:, None])
                send_column(recording, Column(entity, "Scalars", {"scalars": values}), times)
        _log_bifurcations(recording, name, branch)


def _centered(branch: Any, i: int) -> np.ndarray:
    return np.asarray(branch.positions(i) - branch.drop_center(i), dtype=np.float32)


def sheets(end_shortening: np.ndarray) -> list[tuple[int, int]]:
    """Stretches (first, last) of a path along which the end-shortening does not turn."""
    step = np.sign(np.diff(end_shortening))
    turns = np.flatnonzero(step[1:] * step[:-1] < 0) + 1
    edges = [0, *turns.tolist(), len(end_shortening) - 1]
    return list(pairwise(edges))


def lowest_sheet(table: np.ndarray) -> np.ndarray:
    """Which points of a path have no other point of it below them, in E_hat, (T,) of bool."""
    delta, energy = table["end_shortening"], table["energy_hat"]
    least = np.full(len(table), np.inf)
    for first, last in sheets(delta):
        part = slice(first, last + 1)
        order = np.argsort(delta[part])
        here = np.interp(delta, delta[part][order], energy[part][order], left=np.inf, right=np.inf)
        least = np.minimum(least, here)
    return np.asarray(energy <= least + 1e-9 * np.maximum(1, abs(energy)))


def _log_bifurcations(recording: Any, name: str, branch: Any) -> None:
    import rerun as rr

    specials = branch.bifurcations
    if not len(specials):
        return
    recording.send_columns(
        "events",
        indexes=[
            rr.TimeColumn("point", sequence=specials["index"]),
            rr.TimeColumn("end_shortening", duration=specials["end_shortening"]),
        ],
        columns=rr.TextLog.columns(
            text=[
                f"{name}: {row['kind'].decode()} at {row['end_shortening'] / math.pi:.6f} pi, "
                f"t = {row['end_tension']:.4f}, E_hat = {row['energy_hat']:.4f}"
                for row in specials
            ]
        ),
    )


def replay_file(path: str, target: Target, color: str) -> Opened:
    """Replay a run file or a branch file into ``target``. Raises RecordError, TargetError."""
    from derod.views.stream.viewers import drop_recording, open_recording

    name = Path(path).name
    if is_branch_file(path):
        from derod import open_branches

        with open_branches(path) as branches:
            branches.values()  # read, and refused, before a viewer is started
            opened = open_recording(target, name)
            try:
                replay_branches(opened.recording, branches)
            except BaseException:
                drop_recording(opened.recording)
                raise
            return opened
    with open_run(path) as run:
        _ = run.scene, run.table, run.events
        opened = open_recording(target, name)
        try:
            replay_run(opened.recording, run, color)
        except BaseException:
            drop_recording(opened.recording)
            raise
        return opened


def is_branch_file(path: str) -> bool:
    """Whether this is a file of ``derod branch``; what cannot be read is left to the run reader."""
    from derod.branches import is_branch_file

    return is_branch_file(path)
