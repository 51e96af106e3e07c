"""What checksums and locks cost: pushes with a file, with and without them, in turn."""

from __future__ import annotations

import statistics
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from unittest import mock

import derod
from derod.record import growing
from tests.validation.faults.trial import ROOT, Found

MOST = 0.05  # of a push with a file


@contextmanager
def without() -> Iterator[None]:
    """The writer without checksums, their counter, and locks."""

    class NoLock:
        target = None
        descriptor = -1

        @classmethod
        def make(cls, path: str) -> NoLock:
            return cls()

        def release(self) -> None: ...

    class OneCell(growing.Cell):
        def write(self, value: object) -> None:
            if self.dataset.name != "/committed_check":
                super().write(value)

    with (
        mock.patch.object(growing, "frame_digest", lambda *_: 0),
        mock.patch.object(growing, "committed_digest", lambda *_: 0),
        mock.patch.object(growing, "Lock", NoLock),
        mock.patch.object(growing, "Cell", OneCell),
    ):
        yield


def interleaved(folder: Path, pairs: int) -> Found:
    """Pushes of runs/paper-text.toml, CPU seconds, with and without in turn."""
    scene = derod.load_scene(ROOT / "runs" / "paper-text.toml")
    derod.push(scene)

    def seconds(number: int, kind: str) -> float:
        path = folder / f"{kind}-{number}.h5"
        began = time.process_time()
        writer_run(scene, path)
        return time.process_time() - began

    ratios, times = [], []
    for number in range(pairs):
        if number % 2:
            full = seconds(number, "full")
            with without():
                bare = seconds(number, "bare")
        else:
            with without():
                bare = seconds(number, "bare")
            full = seconds(number, "full")
        ratios.append(full / bare - 1)
        times.append(full)
    cost = statistics.median(ratios)
    spread = statistics.quantiles(ratios, n=4)
    found = Found(
        f"cost of checksums and locks, {pairs} pairs of pushes in turn (paper-text, median "
        f"{statistics.median(times):.3f} CPU s): {100 * cost:.1f} % (quartiles {100 * spread[0]:.1f} "
        f"to {100 * spread[2]:.1f} %)"
    )
    found.trials = pairs
    if cost > MOST:
        found.fail(f"{100 * cost:.1f} % is more than {100 * MOST:g} %")
    return found


def writer_run(scene: derod.Scene, path: Path) -> None:
    """A push with a file, not opened for reading afterwards."""
    from derod.api import _drive
    from derod.record import RunWriter

    _drive(scene, RunWriter(path), [], None)
