"""Who pushes the points: this process, or workers of Dask, on this machine or on a cluster.

Both give results as they come. Dask starts the processes, moves the work, and tells which worker died; who
gets which points is ``hand``'s.
"""

from __future__ import annotations

import logging
import os
from collections.abc import Callable, Generator, Iterable, Iterator
from contextlib import ExitStack, contextmanager
from importlib.util import find_spec
from typing import Any

from derod.needs import MissingError, need
from derod.pushing import interrupts
from derod.sweeps.hand import PATIENCE, EngineError, Hand, Task, Work
from derod.sweeps.points import Job, Result

Results = Generator[Result, None, None]
SETTINGS = {
    "distributed.scheduler.allowed-failures": 0,  # ``hand`` counts, point by point
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


def serial(work: Work, job: Job, tasks: Iterable[Task]) -> Results:
    """Push the points in this process, one after another."""
    for point, changes in tasks:
        yield work(job, point, changes)


def parallel(
    work: Work,
    job: Job,
    tasks: Iterable[Task],
    *,
    count: int,
    workers: int,
    scheduler: str | None = None,
    batch: float = 0.0,
    say: Callable[[str], None] = lambda line: None,
) -> Results:
    """Push the points on ``workers`` processes here, or on the cluster of a Dask ``scheduler``'s address.

    A point whose worker dies is pushed again, ``DEATHS`` deaths set it aside (a scheduler of another's
    counts by its own ``allowed-failures``). Where the connection to the scheduler is lost, points under way
    are pushed again when it is back. ``batch``: seconds of work that a worker gets at once; 0 is one point.
    ``count``: how many points there are. Raises EngineError, MissingError.
    """
    with _client(workers, scheduler) as client:
        hand = Hand(client, work, job, foreign=scheduler is not None, batch=batch, say=say)
        yield from hand.out(tasks, count)


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
