"""``derod.push``: a scene, its observers and the driver put together."""

from __future__ import annotations

import math
import os
from collections.abc import Sequence

from derod.errors import RecordError, SceneError
from derod.pushing import interrupts
from derod.pushing.continuing import check_continues
from derod.pushing.frames import Ending, Event, Frame, Observer, Outcome
from derod.pushing.observers import guarded
from derod.record import (
    BaseRun,
    MemoryRun,
    Run,
    RunWriter,
    attach_extrapolated,
    locked,
    open_run,
    resume_copy,
)
from derod.record.extrapolate import coarser
from derod.record.extrapolate import extrapolate as extrapolate_runs
from derod.scene import Scene
from derod.scene.axis import both
from derod.scene.directors import check_pushable
from derod.scene.plain import plain_tables
from derod.scene.plan import check_plan
from derod.scene.reading import build_scene
from derod.scenes import read_scene


def push(
    scene: Scene | str | os.PathLike[str] | None,
    path: str | os.PathLike[str] | None = None,
    observers: Sequence[Observer] = (),
    *,
    resume: str | os.PathLike[str] | None = None,
    overwrite: bool = False,
    extrapolate: bool = False,
    progress: bool = False,
    yes_really: bool = False,
) -> BaseRun:
    """Push the rod of ``scene`` and return the run, open for reading.

    ``scene`` is a scene, a scene file, or the name of a scene that ships with derod (``derod scenes``).

    With ``path`` every increment is committed to that HDF5 file as it settles; without, the run is
    kept in memory. ``observers`` see each frame after it was recorded; one that raises is left out
    from then on, with a line on standard error. ``resume`` goes on, in place, with a run file that
    was killed, interrupted or finished; ``scene`` may then be None, or the same rod pushed further.

    With ``extrapolate`` the push is done once more on half the edges, landing on every row of the first,
    and ``run.extrapolated`` holds better values and estimated errors (``derod.record.extrapolate``).

    With ``progress`` a bar shows how far it is, in a notebook as in a terminal (tqdm.auto).

    A push that plans more rows, or a larger file, than anybody can mean is refused
    (``derod.scene.plan``) unless ``yes_really``.

    However the push ends, also by Ctrl-C, the run says so in ``run.ending``. Raises SceneError for
    a scene that is not allowed and RecordError when the file cannot be written or read.
    """
    if isinstance(scene, str | os.PathLike):
        scene = read_scene(scene)
    if progress:
        from derod.views.progress import Progress

        observers = [Progress(everywhere=True), *observers]
    if extrapolate:
        if scene is not None:
            scene.replace(
                {"mesh.edges": scene.mesh.edges // 2}
            )  # refused now rather than afterwards
        run = push(
            scene, path, observers, resume=resume, overwrite=overwrite, yes_really=yes_really
        )
        return _extrapolated(run)
    if resume is not None:
        if path is not None:
            raise RecordError(f"{os.fspath(path)}: a resumed run goes on in its own file")
        return _resume(scene, resume, observers, yes_really)
    if scene is None:
        raise SceneError("a push that resumes no run needs a scene")
    scene = _checked(scene, yes_really)
    if path is None:
        memory = MemoryRun()
        _drive(scene, memory, observers, None)
        return memory
    writer = RunWriter(path, overwrite=overwrite)
    ending = _drive(scene, writer, observers, None)
    if not writer.began:  # there is no file yet that could say so
        raise KeyboardInterrupt(ending.message)
    return open_run(path)


def _checked(scene: Scene, yes_really: bool) -> Scene:
    """The scene, checked again, since it may have been put together by hand. Raises SceneError."""
    if not isinstance(scene, Scene):
        raise SceneError(
            "is no scene (derod.Scene makes one, derod.load_scene reads one)", value=scene
        )
    scene = build_scene(plain_tables(scene), scene.path)
    check_pushable(scene)
    if not yes_really:
        check_plan(scene)
    return scene


def _resume(
    scene: Scene | None,
    path: str | os.PathLike[str],
    observers: Sequence[Observer],
    yes_really: bool,
) -> Run:
    with locked(path) as lock, open_run(path) as old:
        scene = _checked(old.scene if scene is None else scene, yes_really)
        if old.outcome is Outcome.COMPLETED and scene == old.scene:
            return open_run(path)
        check_continues(old, scene)
        writer = resume_copy(path, scene, lock)
        lock.release()  # the new file has one of its own
        _drive(scene, writer, observers, old if len(old) else None)
    return open_run(path)


def _extrapolated(run: BaseRun) -> BaseRun:
    """Push on half the edges and keep the extrapolated rows with ``run``, if it has any rows.

    Where that push is interrupted the run comes back as it is.
    """
    if run.outcome in (None, Outcome.INTERRUPTED) or not len(run):
        return run
    coarse = push(coarser(run), yes_really=True)
    if coarse.outcome is Outcome.INTERRUPTED:
        return run
    table = extrapolate_runs(coarse, run)
    if isinstance(run, MemoryRun):
        run.keep_extrapolated(table)
        return run
    path = str(run.path)
    run.close()
    attach_extrapolated(path, table)
    return open_run(path)


class _FirstToHear:
    """The observer at the head of the row: knows how far the push came and whether it was ended.

    From the ending on no signal may disturb the others, which write it down.
    """

    def __init__(self) -> None:
        self.end_shortening = math.nan
        self.finished = False

    def start(self, scene: Scene, first_increment: int) -> None: ...

    def event(self, event: Event) -> None: ...

    def frame(self, frame: Frame) -> None: ...

    def finish(self, ending: Ending) -> None:
        self.finished = True
        interrupts.acknowledge()


class _LastToHear(_FirstToHear):
    """The observer at the end of the row: what it has seen, all have."""

    def frame(self, frame: Frame) -> None:
        self.end_shortening = float(frame.row["end_shortening"])


def _drive(
    scene: Scene,
    record: RunWriter | MemoryRun,
    observers: Sequence[Observer],
    resume: Run | None,
) -> Ending:
    """Run the driver; whatever stops it, every observer hears how it ended.

    Only the record can end the push; ``observers`` that raise are left out from then on.
    """
    last = _LastToHear()
    everyone = [_FirstToHear(), record, *guarded(observers), last]

    def end(outcome: Outcome, message: str) -> Ending:
        interrupts.acknowledge()
        ending = Ending(outcome, message, last.end_shortening)
        if not last.finished:
            for observer in everyone:
                observer.finish(ending)
        return ending

    def interrupted() -> Ending:
        place = last.end_shortening
        where = "before the first increment" if math.isnan(place) else f"at {both(place)}"
        return end(Outcome.INTERRUPTED, f"{interrupts.words()} {where}")

    try:
        from derod.pushing.driver import drive  # compiles kernels, which reading runs does not need

        ending = drive(scene, everyone, resume)
    except KeyboardInterrupt:
        return interrupted()
    except RecordError as error:
        end(Outcome.RECORD_FAILED, str(error))
        raise
    except BaseException as error:
        if interrupts.pending() is not None:  # swallowed on its way, it came back as this
            return interrupted()
        end(Outcome.INTERRUPTED, f"stopped by {type(error).__name__}: {error}")
        raise
    if ending.outcome is Outcome.RECORD_FAILED:
        raise RecordError(ending.message)
    return ending
