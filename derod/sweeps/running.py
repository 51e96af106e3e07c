"""A sweep from its plan to its file: what is finished is skipped, what fails is listed, nothing is fatal."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Generator, Iterator
from contextlib import closing
from dataclasses import dataclass, field
from pathlib import Path

from derod.errors import RecordError
from derod.files import outputs
from derod.pushing import interrupts
from derod.pushing.frames import Outcome
from derod.sweeps import engines
from derod.sweeps.files import write_sweep
from derod.sweeps.hand import Task, Work
from derod.sweeps.journal import Journal, folder_of
from derod.sweeps.plan import Plan
from derod.sweeps.points import AGAIN, Job, Result, run_point

ASK = "--force replaces it, -o FILE writes another"


@dataclass(frozen=True, slots=True)
class Means:
    """Who pushes the points, and what is kept."""

    workers: int = 1
    """Processes on this machine; 1 is this process, without Dask."""
    scheduler: str | None = None
    """The address of a Dask scheduler, for a cluster that is there."""
    runs: str | None = None
    """A folder for the full runs, if they are kept."""
    batch: float = 0.5
    """Seconds of work that a worker gets at once, and that its death, or a kill, may cost; 0 is one point."""
    work: Work = run_point
    say: Callable[[str], None] = lambda line: None
    """For remarks: a worker that died, files that were damaged."""


@dataclass(slots=True)
class Tally:
    """How far a sweep is."""

    total: int
    before: int = 0
    """Points that were finished when it began."""
    done: int = 0
    """Points finished since, whatever their outcome."""
    seconds: float = 0.0
    """CPU time of the pushes since."""
    outcomes: Counter[str] = field(default_factory=Counter)

    @property
    def failed(self) -> int:
        """Points, of now and before, that did not complete."""
        return sum(n for outcome, n in self.outcomes.items() if outcome != Outcome.COMPLETED)


Watch = Callable[[Tally], None]


def check_target(path: Path, *, overwrite: bool) -> Path:
    """The file of a sweep that begins, where neither a file nor a journal is in the way.

    Raises RecordError.
    """
    target = outputs.check_output(path, force=overwrite, ask=ASK)
    journal = folder_of(target)
    if journal.exists() and not overwrite:
        raise outputs.RefusedError(
            f"{path}: a sweep was begun there ({journal.name}); --resume {path} goes on with it, "
            "--force begins anew"
        )
    return target


def run_sweep(
    plan: Plan | None,
    path: Path,
    means: Means,
    *,
    overwrite: bool = False,
    watch: Watch = lambda tally: None,
) -> Tally:
    """Push every point of a plan and write the sweep's file; without a plan go on with one that was begun.

    However it ends, also by Ctrl-C, what is finished stays in the journal beside ``path``; it is removed
    when all points are in the file. Raises RecordError, EngineError, KeyboardInterrupt.
    """
    if plan is None:
        target = outputs.check_output(path, force=True)
        journal = Journal.resume(target)
        if journal.damaged:
            means.say(f"{journal.damaged} files of finished points are damaged: pushed again")
    else:
        target = check_target(path, overwrite=overwrite)
        journal = Journal.begin(target, plan)
    with journal:
        return _go_on(journal, target, means, watch)


def _go_on(journal: Journal, target: Path, means: Means, watch: Watch) -> Tally:
    plan = journal.plan
    tally = Tally(plan.count, before=len(journal))
    counts: dict[int, int] = {}
    failed: dict[int, Result] = {}

    def take(result: Result) -> None:
        tally.outcomes[result.outcome] += 1
        counts[result.point] = len(result.rows)
        if result.outcome in AGAIN:
            failed[result.point] = result

    for point in journal:
        take(journal.read(point))
    watch(tally)
    try:
        with closing(_results(plan, journal, means)) as results:
            for result in results:
                journal.put(result)
                take(result)
                tally.done += 1
                tally.seconds += result.seconds
                watch(tally)
    except BaseException as error:
        if isinstance(error, KeyboardInterrupt):
            interrupts.acknowledge()
            means.say(
                f"{len(journal)} of {plan.count} points are kept; derod sweep --resume {target} goes on"
            )
        _write(journal, target, failed, counts, quiet=True)
        raise
    _write(journal, target, failed, counts, quiet=False)
    if not failed:
        journal.remove()
    return tally


def _results(plan: Plan, journal: Journal, means: Means) -> Generator[Result, None, None]:
    """The results of all points that are not finished, as they come."""
    job = Job(plan.scene.text, plan.scene.path, plan.rows, means.runs)
    waiting: Iterator[Task] = (
        (point, plan.changes(values))
        for point, values in enumerate(plan.points())
        if point not in journal
    )
    alone = means.scheduler is None and means.workers == 1
    if alone or len(journal) == plan.count:
        return engines.serial(means.work, job, waiting)
    return engines.parallel(
        means.work,
        job,
        waiting,
        count=plan.count - len(journal),
        workers=means.workers,
        scheduler=means.scheduler,
        batch=means.batch,
        say=means.say,
    )


def _write(
    journal: Journal, target: Path, failed: dict[int, Result], counts: dict[int, int], quiet: bool
) -> None:
    """Write what there is; ``quiet`` where something else is wrong already, which shall be told."""

    def read(point: int) -> Result | None:
        return journal.read(point) if point in journal else failed.get(point)

    try:
        write_sweep(target, journal.plan, read, counts)
    except RecordError:
        if not quiet:
            raise
