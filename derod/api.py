"""``derod.push``: a scene, its observers and the driver put together."""

from __future__ import annotations

import math
import os
from collections.abc import Sequence

from derod.errors import RecordError, SceneError
from derod.extrapolate import coarser
from derod.extrapolate import extrapolate as extrapolate_runs
from derod.frames import Ending, Event, Frame, Observer, Outcome
from derod.record import (
    BaseRun,
    MemoryRun,
    Run,
    RunWriter,
    attach_extrapolated,
    open_run,
    resume_copy,
)
from derod.scene import Scene
from derod.scene.material import check_one_stiffness
from derod.scene.reading import build_scene, plain_tables


def push(
    scene: Scene | None,
    path: str | os.PathLike[str] | None = None,
    observers: Sequence[Observer] = (),
    *,
    resume: str | os.PathLike[str] | None = None,
    overwrite: bool = False,
    extrapolate: bool = False,
) -> BaseRun:
    """Push the rod of ``scene`` and return the run, open for reading.

    With ``path`` every increment is committed to that HDF5 file as it settles; without, the run is
    kept in memory. ``observers`` see each frame after it was recorded. ``resume`` goes on, in
    place, with a run file that was killed, interrupted or finished; ``scene`` may then be None, or
    the same rod pushed further.

    With ``extrapolate`` the push is done once more on half the edges, landing on every row of the first,
    and ``run.extrapolated`` holds better values and estimated errors (``derod.extrapolate``).

    However the push ends, also by Ctrl-C, the run says so in ``run.ending``. Raises SceneError for
    a scene that is not allowed and RecordError when the file cannot be written or read.
    """
    if extrapolate:
        if scene is not None:
            scene.replace(
                {"mesh.edges": scene.mesh.edges // 2}
            )  # refused now rather than afterwards
        run = push(scene, path, observers, resume=resume, overwrite=overwrite)
        return _extrapolated(run)
    if resume is not None:
        if path is not None:
            raise RecordError(f"{os.fspath(path)}: a resumed run goes on in its own file")
        return _resume(scene, resume, observers)
    if scene is None:
        raise SceneError("a push that resumes no run needs a scene")
    scene = build_scene(plain_tables(scene), scene.path)  # it may have been put together by hand
    check_one_stiffness(scene)
    if path is None:
        memory = MemoryRun()
        _drive(scene, [memory, *observers], None)
        return memory
    _drive(scene, [RunWriter(path, overwrite=overwrite), *observers], None)
    return open_run(path)


def _resume(
    scene: Scene | None, path: str | os.PathLike[str], observers: Sequence[Observer]
) -> Run:
    with open_run(path) as old:
        scene = old.scene if scene is None else scene
        scene = build_scene(plain_tables(scene), scene.path)
        check_one_stiffness(scene)
        if old.outcome is Outcome.COMPLETED and scene == old.scene:
            return open_run(path)
        check_continues(old, scene)
        _drive(scene, [resume_copy(path, scene), *observers], old if len(old) else None)
    return open_run(path)


def _extrapolated(run: BaseRun) -> BaseRun:
    """Push on half the edges and keep the extrapolated rows with ``run``, if it has any rows."""
    if run.outcome in (None, Outcome.INTERRUPTED) or not len(run):
        return run
    coarse = push(coarser(run))
    table = extrapolate_runs(coarse, run)
    if isinstance(run, MemoryRun):
        run.keep_extrapolated(table)
        return run
    path = str(run.path)
    run.close()
    attach_extrapolated(path, table)
    return open_run(path)


def check_continues(old: BaseRun, scene: Scene) -> None:
    """Raise SceneError unless ``scene`` is what ``old`` ran, but for where the push goes next."""
    before = old.scene
    for table in ("material", "rod", "drop", "clamps", "mesh", "noise", "model"):
        if getattr(scene, table) != getattr(before, table):
            raise SceneError("differs from the run that is resumed", file=scene.path, key=table)
    if scene.push.start != before.push.start:
        raise SceneError("differs from the run that is resumed", file=scene.path, key="push.start")
    if not len(old):
        return
    leg, reached = int(old.table["segment"][-1]), float(old.table["end_shortening"][-1])
    if len(scene.push.stop) <= leg or scene.push.stop[:leg] != before.push.stop[:leg]:
        raise SceneError("differs in a leg that is done", file=scene.path, key="push.stop")
    begin = (before.push.start, *before.push.stop)[leg]
    onward = math.copysign(1.0, before.push.stop[leg] - begin)
    if (scene.push.stop[leg] - reached) * onward < 0.0:
        raise SceneError(
            "has been passed",
            file=scene.path,
            key="push.stop",
            value=scene.push.stop[leg],
            allowed=f"{'at least' if onward > 0.0 else 'at most'} {reached:.6g}, where the run is",
        )


class _LastSeen:
    """The observer at the end of the row: knows how far the push came and whether it was ended."""

    def __init__(self) -> None:
        self.end_shortening = float("nan")
        self.finished = False

    def start(self, scene: Scene, first_increment: int) -> None: ...

    def event(self, event: Event) -> None: ...

    def frame(self, frame: Frame) -> None:
        self.end_shortening = float(frame.row["end_shortening"])

    def finish(self, ending: Ending) -> None:
        self.finished = True


def _drive(scene: Scene, observers: Sequence[Observer], resume: Run | None) -> Ending:
    """Run the driver; whatever stops it, every observer hears how it ended."""
    from derod.driver import drive  # compiles kernels, which reading runs does not need

    last = _LastSeen()
    everyone = [*observers, last]

    def end(outcome: Outcome, message: str) -> Ending:
        ending = Ending(outcome, message, last.end_shortening)
        if not last.finished:
            for observer in everyone:
                observer.finish(ending)
        return ending

    try:
        ending = drive(scene, everyone, resume)
    except KeyboardInterrupt:
        return end(Outcome.INTERRUPTED, "interrupted from outside")
    except RecordError as error:
        end(Outcome.RECORD_FAILED, str(error))
        raise
    except BaseException as error:
        end(Outcome.INTERRUPTED, f"stopped by {type(error).__name__}: {error}")
        raise
    if ending.outcome is Outcome.RECORD_FAILED:
        raise RecordError(ending.message)
    return ending
