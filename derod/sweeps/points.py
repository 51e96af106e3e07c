"""One point of a sweep pushed: a function of plain data, so that any process can do it."""

from __future__ import annotations

import os
import threading
import time
from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np

from derod.errors import DerodError, RecordError, SceneError
from derod.pushing.frames import Ending, Outcome
from derod.record import BaseRun, MemoryRun, RunWriter, open_run
from derod.record.ending import ending_words
from derod.scene import Scene, parse_scene
from derod.scene.directors import check_pushable
from derod.scene.plan import check_plan
from derod.sweeps.table import PUSHED, rows_of

REFUSED = "not_allowed"
"""The outcome of a point whose values make no scene."""
FAILED = "error"
"""The outcome of a point at which something broke."""
KILLED = "killed_worker"
"""The outcome of a point that killed its workers."""
AGAIN = (FAILED, KILLED, str(Outcome.RECORD_FAILED))
"""Outcomes that a sweep that is resumed tries again."""
_one_at_a_time = threading.Lock()


@dataclass(frozen=True, slots=True)
class Job:
    """What all points of a sweep share."""

    scene: str
    """The text of the scene."""
    path: str | None
    """The scene's file, for messages."""
    rows: str
    runs: str | None = None
    """The folder for the full runs, if they are kept."""


@dataclass(frozen=True, slots=True)
class Result:
    """What became of one point."""

    point: int
    outcome: str
    message: str
    rows: np.ndarray
    """Of ``PUSHED``."""
    seconds: float = 0.0
    """CPU time of the push, kernels being compiled or loaded left out."""


def run_point(job: Job, point: int, changes: Mapping[str, Any]) -> Result:
    """Push the scene with a point's changes. A push that fails is a result; raises KeyboardInterrupt.

    In a process with several threads, as workers of a cluster may have, one point is pushed at a time.
    """
    with _one_at_a_time:
        try:
            scene = scene_of(job.scene, job.path).replace(changes)
            check_pushable(scene)
            check_plan(scene)
        except SceneError as error:
            return Result(point, REFUSED, str(error), np.zeros(0, PUSHED))
        try:
            file = None if job.runs is None else run_file(job.runs, point)
            from derod.algebra import compiling

            began, compiled = time.thread_time(), compiling.seconds()
            with pushed(scene, file) as run:
                seconds = time.thread_time() - began - (compiling.seconds() - compiled)
                ending = run.ending
                assert ending is not None
                if ending.outcome is Outcome.INTERRUPTED:
                    raise KeyboardInterrupt(ending.message)
                message = ending_words(ending).partition(": ")[2]
                kept = rows_of(run, job.rows)
                return Result(point, str(ending.outcome), message, kept, max(seconds, 0.0))
        except RecordError as error:
            return Result(point, str(Outcome.RECORD_FAILED), str(error), np.zeros(0, PUSHED))
        except (DerodError, ArithmeticError, ValueError, MemoryError) as error:
            said = f"{type(error).__name__}: {error}"
            return Result(point, FAILED, said, np.zeros(0, PUSHED))


def pushed(scene: Scene, path: Path | None = None) -> BaseRun:
    """The run of a checked scene, in memory or in a file that it replaces. Raises RecordError."""
    from derod.pushing.driver import drive  # compiles kernels, which reading sweeps does not need

    if path is None:
        memory = MemoryRun()
        drive(scene, [memory])
        return memory
    writer = RunWriter(path, overwrite=True)
    ending: Ending = drive(scene, [writer])
    if ending.outcome is Outcome.RECORD_FAILED:
        raise RecordError(ending.message)
    if not writer.began:
        raise KeyboardInterrupt(ending.message)
    return open_run(path)


def run_file(folder: str, point: int) -> Path:
    """The file of the full run of a point."""
    return Path(os.path.realpath(folder)) / f"{point:06}.h5"


@lru_cache(maxsize=4)
def scene_of(text: str, path: str | None) -> Scene:
    """The scene that all points share, read once."""
    return parse_scene(text, path=path)
