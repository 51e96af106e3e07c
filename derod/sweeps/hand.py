"""Hands out points to the workers of Dask and takes in their results.

A worker has one batch of points at a time, and nothing waits behind it, so that memory is bounded and a
death is blamed on what was running. A batch is what takes about ``batch`` seconds: Dask takes some 6 ms of
CPU time to hand anything out, a push of 100 edges some 100 ms. Points of a batch that came to grief are
handed out singly.
"""

from __future__ import annotations

from collections import Counter, deque
from collections.abc import Callable, Iterable, Iterator, Mapping
from itertools import islice
from typing import Any

import numpy as np

from derod.errors import DerodError
from derod.sweeps.points import FAILED, KILLED, Job, Result
from derod.sweeps.table import PUSHED

Work = Callable[[Job, int, Mapping[str, Any]], Result]
Task = tuple[int, Mapping[str, Any]]
DEATHS = 2
"""Of workers by a point alone, after which it is set aside."""
LOSSES = 5
"""Of a point's result on its way, after which it counts as failed."""
LOOK_AT_WORKERS = 16
"""Batches handed out between two looks at who is there, while all are."""
MOST = 32
"""Points in a batch."""
SHARE = 4
"""A batch is at most this part of what each worker has left to do."""
PATIENCE = 60.0  # s, without any worker


class EngineError(DerodError):
    """Nobody is there to push the points."""


def run_batch(work: Work, job: Job, batch: list[Task]) -> list[Result]:
    """Push the points of a batch, one after another, in a worker."""
    return [work(job, point, changes) for point, changes in batch]


class Hand:
    """Hands out ``count`` points to the workers of a client."""

    def __init__(
        self,
        client: Any,
        work: Work,
        job: Job,
        *,
        foreign: bool,
        batch: float,
        say: Callable[[str], None],
    ) -> None:
        self.client, self.work, self.job = client, work, job
        self.foreign, self.batch, self.say = foreign, batch, say
        self.deaths, self.lost = Counter[int](), Counter[int]()
        self.under_way: dict[Any, list[Task]] = {}
        self.again: deque[Task] = deque()
        self.tries = self.results = 0
        self.seconds = 0.0

    def out(self, tasks: Iterable[Task], count: int) -> Iterator[Result]:
        """All results, as they come."""
        from distributed import as_completed

        left, coming = iter(tasks), as_completed()
        slots = most = self.slots()
        while True:
            while len(self.under_way) < slots:
                size = self.size((count - self.results) / slots)
                batch = [self.again.popleft()] if self.again else list(islice(left, size))
                if not batch:
                    break
                coming.add(self.submit(batch))
            if not self.under_way:
                return
            # all that is there, before a worker that has results gets more to do, and may die of it
            futures = coming.next_batch(block=True)
            batches = [self.under_way.pop(future) for future in futures]
            results = [r for f, b in zip(futures, batches, strict=True) for r in self.taken(f, b)]
            if (
                len(results) < sum(map(len, batches))
                or slots < most
                or self.tries % LOOK_AT_WORKERS == 0
            ):
                slots = self.slots()  # one may have died, or come back
                most = max(most, slots)
            for result in results:
                self.results += 1
                self.seconds += result.seconds
                yield result

    def size(self, left: float) -> int:
        """How many points the next batch has, where a worker has ``left`` of them to do."""
        if not self.seconds:
            return 1
        wanted = self.batch * self.results / self.seconds
        return max(1, int(min(wanted, MOST, left / SHARE)))

    def submit(self, batch: list[Task]) -> Any:
        """Hand out a batch."""
        self.tries += 1
        key = f"derod-points-{batch[0][0]}-{self.tries}"
        try:
            future = self.client.submit(run_batch, self.work, self.job, batch, key=key, pure=False)
        except Exception as error:  # whatever Dask raises where the scheduler is gone
            raise EngineError(f"the scheduler takes no more points: {error}") from error
        self.under_way[future] = batch
        return future

    def taken(self, future: Any, batch: list[Task]) -> list[Result]:
        """The results of a batch; points of which there is none are handed out again."""
        if future.status == "finished":
            try:
                found = future.result()
            except Exception as error:  # lost on its way, with its worker
                return self.missing(batch, f"its result was lost: {error!r}")
            return self.checked(found, batch)
        if future.status != "error":  # cancelled: the scheduler has gone, and may be back
            results = self.missing(batch, "the scheduler lost it")
            self.wait()
            return results
        return self.failed(future.exception(), batch)

    def failed(self, error: Any, batch: list[Task]) -> list[Result]:
        """What becomes of a batch that ended with an error."""
        from distributed.scheduler import KilledWorker

        died = isinstance(error, KilledWorker)
        if len(batch) > 1:  # one of them did it: each by itself will tell
            if died:
                self.say(
                    f"points {', '.join(str(p) for p, _ in batch)}: their worker died: once more"
                )
            self.again.extend(batch)
            return []
        point = batch[0][0]
        if not died:
            return [_nothing(point, FAILED, f"{type(error).__name__}: {error}")]
        self.deaths[point] += 1
        if self.foreign or self.deaths[point] >= DEATHS:  # others count by themselves
            times = "again and again" if self.foreign else f"{DEATHS} times"
            return [_nothing(point, KILLED, f"the worker that pushed it died {times}")]
        self.say(f"point {point}: its worker died: once more")
        self.again.append(batch[0])
        return []

    def missing(self, batch: list[Task], why: str) -> list[Result]:
        """Hand out again what was lost on its way, unless that happens again and again."""
        results = []
        for task in batch:
            point = task[0]
            self.lost[point] += 1
            if self.lost[point] >= LOSSES:
                results.append(_nothing(point, FAILED, why))
                continue
            self.say(f"point {point}: {why}: again")
            self.again.append(task)
        return results

    def checked(self, found: Any, batch: list[Task]) -> list[Result]:
        """Results that are those of the batch."""
        if [getattr(result, "point", None) for result in found] == [point for point, _ in batch]:
            return [
                result
                if isinstance(result, Result) and result.rows.dtype == PUSHED
                else _nothing(point, FAILED, "its worker has another version of derod")
                for result, (point, _) in zip(found, batch, strict=True)
            ]
        return [
            _nothing(point, FAILED, "its worker has another version of derod") for point, _ in batch
        ]

    def slots(self) -> int:
        """How many batches may be under way: one a worker, and one where none is there yet."""
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
