"""Runs in memory offer what run files offer."""

from __future__ import annotations

import numpy as np
import pytest

from derod.errors import RecordError
from derod.pushing.frames import Outcome
from derod.pushing.rows import ROW
from derod.record import MemoryRun
from tests.synthetic import drive, make_frame, small_scene


def test_a_run_in_memory() -> None:
    run = MemoryRun()
    with pytest.raises(RecordError, match="not begun"):
        run.scene  # noqa: B018
    scene = small_scene()
    drive(scene, [run])
    assert run.scene == scene
    assert len(run) == 40
    assert run.table.dtype == ROW
    assert run.positions(-1).shape == (scene.mesh.edges + 1, 3)
    assert np.array_equal(run.drop_center(3), [3, 3.25, -3])
    assert run.outcome is Outcome.COMPLETED
    assert [event.increment for event in run.events] == list(range(4, 40, 5))
    with pytest.raises(IndexError):
        run.arc_length(40)


def test_it_keeps_copies() -> None:
    run, frame = MemoryRun(), make_frame(0, 24)
    run.start(small_scene(), 0)
    run.frame(frame)
    before = frame.positions.copy()
    frame.positions[:] = 0.0
    frame.row["end_tension"] = -1.0
    assert np.array_equal(run.positions(0), before)
    assert run.table["end_tension"][0] == 10.0


def test_it_does_not_go_on_from_elsewhere() -> None:
    with pytest.raises(RecordError, match="increment 3"):
        MemoryRun().start(small_scene(), 3)
