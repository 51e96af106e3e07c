"""What a series of trials found, and the processes that trials start."""

from __future__ import annotations

import os
import subprocess
import sys
import time
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

ROOT = Path(__file__).parents[3]
PATIENCE = 600.0  # s, for kernels that are compiled on a busy machine


@dataclass
class Found:
    """One row of the table: how often what was tried, what came of it, and what should not have."""

    what: str
    trials: int = 0
    counts: Counter[str] = field(default_factory=Counter)
    failures: list[str] = field(default_factory=list)
    slowest: float = 0.0  # s

    def add(self, outcome: str, seconds: float = 0.0) -> None:
        """Take in a trial."""
        self.trials += 1
        self.counts[outcome] += 1
        self.slowest = max(self.slowest, seconds)

    def fail(self, text: str) -> None:
        """Take in what should not have been."""
        self.failures.append(text)

    def line(self) -> str:
        """The row, in Markdown."""
        counts = ", ".join(f"{number} {name}" for name, number in sorted(self.counts.items()))
        slowest = f"{self.slowest:.2g} s" if self.slowest else ""
        return f"| {self.what} | {self.trials} | {counts} | {slowest} | {len(self.failures)} |"


def environment(**changes: str) -> dict[str, str]:
    """One thread, and the tree that is tested."""
    return {
        **os.environ,
        "OMP_NUM_THREADS": "1",
        "OPENBLAS_NUM_THREADS": "1",
        "PYTHONPATH": str(ROOT),
        **changes,
    }


def start(
    arguments: Sequence[object], module: str = "derod", **changes: str
) -> subprocess.Popen[str]:
    """``python -m MODULE ARGUMENTS``, its output kept."""
    return subprocess.Popen(
        [sys.executable, "-m", module, *map(str, arguments)],
        cwd=ROOT,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env=environment(**changes),
    )


def ended(process: subprocess.Popen[str], patience: float = PATIENCE) -> tuple[int, str, str]:
    """Wait for a process: its exit code and what it said; it is killed when it takes too long."""
    try:
        out, err = process.communicate(timeout=patience)
    except subprocess.TimeoutExpired:
        process.kill()
        out, err = process.communicate()
        return -999, out, err
    return process.returncode, out, err


def command(*arguments: object, **changes: str) -> tuple[int, str, str]:
    """Run derod to its end."""
    return ended(start(arguments, **changes))


def wait_until(ready: object, patience: float = PATIENCE) -> bool:
    """Wait until ``ready()`` is true."""
    end = time.monotonic() + patience
    while time.monotonic() < end:
        if ready():  # type: ignore[operator]
            return True
        time.sleep(0.002)
    return False
