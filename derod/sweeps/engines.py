"""Who pushes the points: this process, or workers of Dask, on this machine or on a cluster.

Both give results as they come. Dask starts the processes, moves the work, and tells which worker died; what
is left to us is to hand out one point a worker, so that memory is bounded, and that a death is blamed on
the point that was running and on no other.
"""

from __future__ import annotations

import logging
import os
from collections import Counter
from collections.abc import Callable, Generator, Iterable, Iterator, Mapping
from contextlib import ExitStack, contextmanager
from importlib.util import find_spec
from typing import Any

import numpy as np

from derod.errors import DerodError
from derod.needs import MissingError, need
from derod.pushing import interrupts
from derod.sweeps.points import FAILED, KILLED, Job, Result
from derod.sweeps.table import PUSHED

Work = Callable[[Job, int, Mapping[str, Any]], Result]
Results = Generator[Result, None, None]
Task = tuple[int, Mapping[str, Any]]
DEATHS = 2
"""Of workers, after which a point is set aside."""
LOSSES = 5
"""Of a point's result on its way, after which it counts as failed."""
LOOK_AT_WORKERS = 16
"""Points handed out between two looks at who is there, while all are."""
PATIENCE = 60.0  # s, without any worker
SETTINGS = {
    "distributed.scheduler.allowed-failures": 0,  # we count, point by point
    "distributed.worker.daemon": True,
    # what watches the workers many times a second would cost a fifth of the pushes' own time
    "distributed.worker.profile.enabled": False,
    "distributed.scheduler.work-stealing": False,  # nothing waits that could be stolen
    "distributed.scheduler.active-memory-manager.start": False,
    "distributed.client.scheduler-info-interval": "60s",
    "distributed.worker.memory.monitor-interval": "1s",
    "distributed.admin.system-monitor.interval": "5s",
    "distributed.admin.system-monitor.gil.enabled": False,
    "distributed.admin.system-monitor.disk": False,
    "distributed.admin.tick.interval": "1s",
    "distributed.admin.tick.limit": "60s",
    "distributed.admin.log-format": "%(message)s",
}


class EngineError(DerodError):
    """Nobody is there to push the points."""


def serial(work: Work, job: Job, tasks: Iterable[Task]) -> Results:
    """Push the points in this process, one after another."""
    for point, changes in tasks:
        yield work(job, point, changes)


def parallel(
    work: Work,
    job: Job,
    tasks: Iterable[Task],
    *,
    workers: int,
    scheduler: str | None = None,
    say: Callable[[str], None] = lambda line: None,
) -> Results:
    """Push the points on ``workers`` processes here, or on the cluster of a Dask ``scheduler``'s address.

    A point whose worker dies is pushed again, ``DEATHS`` deaths set it aside (a scheduler of another's
    counts by its own ``allowed-failures``). Where the connection to the scheduler is lost, points under way
    are pushed again when it is back. Raises EngineError, MissingError.
    """
    with _client(workers, scheduler) as client:
        yield from _Hand(client, work, job, foreign=scheduler is not None, say=say).out(tasks)


class _Hand:
    """Hands out points, one a worker, and takes in results."""

    def __init__(
        self, client: Any, work: Work, job: Job, *, foreign: bool, say: Callable[[str], None]
    ) -> None:
        self.client, self.work, self.job = client, work, job
        self.foreign, self.say = foreign, say
        self.deaths, self.lost = Counter[int](), Counter[int]()
        self.under_way: dict[Any, Task] = {}
        self.tries = 0

    def out(self, tasks: Iterable[Task]) -> Iterator[Result]:
        """All results, as they come."""
        from distributed import as_completed

        left, again = iter(tasks), list[Task]()
        coming = as_completed()
        slots = most = self.slots()
        while True:
            while len(self.under_way) < slots:
                task = again.pop() if again else next(left, None)
                if task is None:
                    break
                coming.add(self.submit(task))
            if not self.under_way:
                return
            future = next(coming)
            task = self.under_way.pop(future)
            result = self.result(future, task)
            if result is None:
                again.append(task)
            else:
                yield result
            if result is None or slots < most or self.tries % LOOK_AT_WORKERS == 0:
                slots = self.slots()  # one may have died, or come back
                most = max(most, slots)

    def submit(self, task: Task) -> Any:
        """Hand out one point."""
        point, changes = task
        self.tries += 1
        try:
            future = self.client.submit(
                self.work,
                self.job,
                point,
                changes,
                key=f"derod-point-{point}-{self.tries}",
                pure=False,
            )
        except Exception as error:  # whatever Dask raises where the scheduler is gone
            raise EngineError(f"the scheduler takes no more points: {error}") from error
        self.under_way[future] = task
        return future

    def result(self, future: Any, task: Task) -> Result | None:
        """What became of a point; None where it has to be pushed again."""
        from distributed.scheduler import KilledWorker

        point = task[0]
        if future.status == "finished":
            try:
                return self.checked(future.result(), point)
            except Exception as trouble:  # lost on its way, with its worker
                self.lost[point] += 1
                if self.lost[point] >= LOSSES:
                    return _nothing(point, FAILED, f"its result was lost: {trouble!r}")
                self.say(f"point {point}: its result was lost: again")
                return None
        if future.status != "error":  # cancelled: the scheduler has gone, and may be back
            self.say(f"point {point}: the scheduler lost it: again")
            self.wait()
            return None
        error = future.exception()
        if not isinstance(error, KilledWorker):
            return _nothing(point, FAILED, f"{type(error).__name__}: {error}")
        self.deaths[point] += 1
        if self.foreign or self.deaths[point] >= DEATHS:
            times = f"{DEATHS} times" if not self.foreign else "again and again"
            return _nothing(point, KILLED, f"the worker that pushed it died {times}")
        self.say(f"point {point}: its worker died: once more")
        return None

    def checked(self, result: Any, point: int) -> Result:
        """A result that is one."""
        if isinstance(result, Result) and result.point == point and result.rows.dtype == PUSHED:
            return result
        return _nothing(point, FAILED, "its worker has another version of derod")

    def slots(self) -> int:
        """How many points may be under way: one a worker, and one where none is there yet."""
        try:
            return max(len(self.client.nthreads()), 1)
        except Exception:  # the connection is lost: futures will say so
            return 1

    def wait(self) -> None:
        """Wait until there is a worker again."""
        try:
            self.client.wait_for_workers(1, timeout=PATIENCE)
        except Exception as error:
            raise EngineError(f"the scheduler has gone, or has no worker: {error}") from error


def _nothing(point: int, outcome: str, message: str) -> Result:
    return Result(point, outcome, message, np.zeros(0, PUSHED))


@contextmanager
def _client(workers: int, scheduler: str | None) -> Iterator[Any]:
    """A client of the cluster, which is ours unless ``scheduler`` says where another one is."""
    try:
        dask, distributed = need("dask", "a sweep"), need("distributed", "a sweep")
    except MissingError as error:
        raise MissingError(
            "a sweep in several processes needs dask and distributed, which are not installed: "
            "pip install 'derod[sweep]' (or --workers 1)"
        ) from error
    with ExitStack() as stack:
        stack.enter_context(dask.config.set(SETTINGS))
        for name in ("distributed", "tornado"):  # deaths are told by us, point by point
            stack.enter_context(_quiet(logging.getLogger(name)))
        if scheduler is None:
            cluster: Any = stack.enter_context(
                distributed.LocalCluster(
                    n_workers=workers,
                    threads_per_worker=1,
                    processes=True,
                    dashboard_address=None,
                    preload="derod.sweeps.worker",
                    silence_logs=logging.CRITICAL,
                )
            )
            client = stack.enter_context(distributed.Client(cluster))
            with _undisturbed():
                yield client
            return
        try:
            client = stack.enter_context(distributed.Client(scheduler, timeout=10.0))
            client.wait_for_workers(1, timeout=PATIENCE)
        except (OSError, ValueError, TimeoutError) as error:
            raise EngineError(f"--scheduler = {scheduler}: is not reached: {error}") from error
        with _undisturbed():
            yield client


@contextmanager
def _undisturbed() -> Iterator[None]:
    """Let no second signal disturb the end of workers when a first one has ended the sweep."""
    try:
        yield
    except (KeyboardInterrupt, GeneratorExit):
        interrupts.acknowledge()
        raise


@contextmanager
def _quiet(logger: logging.Logger) -> Iterator[None]:
    before = logger.level
    logger.setLevel(logging.CRITICAL)
    try:
        yield
    finally:
        logger.setLevel(before)


def workers_or_default(
    wanted: int | None, scheduler: str | None, say: Callable[[str], None]
) -> int:
    """As many processes as were asked for; else one a core, or this one where Dask is not installed."""
    if wanted is not None or scheduler is not None:
        return wanted or 1
    if find_spec("distributed") is None:
        say("dask and distributed are not installed (pip install 'derod[sweep]'): one process")
        return 1
    return cores()


def cores() -> int:
    """The cores that this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1
