"""Work for the points of sweeps under test: worker processes import it from here."""

from __future__ import annotations

import os
import signal
import time
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from derod.sweeps.points import Job, Result, run_point
from derod.sweeps.table import PUSHED

SLOW = 0.05  # s


def quick(job: Job, point: int, changes: Mapping[str, Any]) -> Result:
    """A row that tells its values, without a push, and a line in the folder's log."""
    _note(job, point)
    time.sleep(SLOW)
    rows = np.zeros(1, PUSHED)
    rows["end_tension"] = changes["drop.capillary_force"] * 2.0
    rows["increment"] = point
    return Result(point, "completed", f"point {point}", rows, 0.01)


def poisonous(job: Job, point: int, changes: Mapping[str, Any]) -> Result:
    """Like ``quick``, but point 3 kills the process that tries it."""
    if point == 3:
        _note(job, point)
        os.kill(os.getpid(), signal.SIGKILL)
    return quick(job, point, changes)


def once_deadly(job: Job, point: int, changes: Mapping[str, Any]) -> Result:
    """Like ``quick``, but the first try of points 2 and 5 kills its process."""
    if point in (2, 5) and point not in tried(str(job.runs)):
        _note(job, point)
        os.kill(os.getpid(), signal.SIGKILL)
    return quick(job, point, changes)


def broken(job: Job, point: int, changes: Mapping[str, Any]) -> Result:
    """Like ``quick``, but point 1 raises what nobody expects."""
    if point == 1:
        raise RuntimeError("a bug")
    return quick(job, point, changes)


def pushing(job: Job, point: int, changes: Mapping[str, Any]) -> Result:
    """A real push, noted."""
    result = run_point(Job(job.scene, job.path, job.rows), point, changes)
    _note(job, point)
    return result


def tried(folder: str) -> list[int]:
    """The points in the order in which they were begun."""
    log = Path(folder) / "log"
    return [int(line) for line in log.read_text().split()] if log.exists() else []


def processes(folder: str) -> list[int]:
    """The processes that began points, the last one last."""
    return [int(line) for line in (Path(folder) / "processes").read_text().split()]


def _note(job: Job, point: int) -> None:
    with (Path(str(job.runs)) / "log").open("a") as log:
        log.write(f"{point}\n")
    with (Path(str(job.runs)) / "processes").open("a") as log:
        log.write(f"{os.getpid()}\n")
