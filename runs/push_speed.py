"""Time pushes against version 0.1 on the same machine, and hold their states together.

    python runs/push_speed.py
    python runs/push_speed.py --repeats 15 --scenes paper-text
    python runs/push_speed.py --file --scenes paper-text

Version 0.1 (commit 9e95062) is taken out of this repository's history. The two versions run in turn, each
in a process of its own that compiles first; what is compared is the CPU time of whole pushes, kept in memory
or, with ``--file``, in a run file. At all common end-shortenings the states must agree in t and E_hat to
1e-9. Exit code 1 where they do not.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path

from bench.old import old_sources

HERE = Path(__file__).parent
SCENES = ("paper-text", "paper-figures", "l20-r0", "l20-r2pi")
SAME = 1e-9

WORKER = """
import json, os, sys, tempfile, time
import derod
folder = tempfile.TemporaryDirectory()
into = {"path": os.path.join(folder.name, "run.h5"), "overwrite": True} if FILE else {}
scenes = [derod.load_scene(name) for name in sys.argv[1:]]
scenes = [scene.replace({"push.at": [0.1 * k for k in range(1, int(10 * scene.push.stop[-1]) + 1)
                                     if 0.1 * k < scene.push.stop[-1]]}) for scene in scenes]
for line in sys.stdin:
    scene = scenes[int(line)]
    clock = time.process_time()
    run = derod.push(scene, **into)
    seconds = time.process_time() - clock
    rows = [[float(row[n]) for n in ("end_shortening", "end_tension", "energy_hat")]
            for row in run.table]
    iterations = int(run.table["iterations"].sum())
    print(json.dumps([seconds, rows, iterations, str(run.ending.outcome)]), flush=True)
"""


class Worker:
    """A process that pushes scenes with one version of the package, on demand."""

    def __init__(self, sources: Path, scenes: list[str], *, file: bool) -> None:
        own = {
            "PYTHONPATH": str(sources),
            "OPENBLAS_NUM_THREADS": "1",
            "OMP_NUM_THREADS": "1",
            "NUMBA_NUM_THREADS": "1",
        }
        self.process = subprocess.Popen(
            [sys.executable, "-c", f"FILE = {file}\n{WORKER}", *scenes],
            env={**os.environ, **own},
            cwd=sources,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
        )

    def push(self, which: int) -> tuple[float, list[list[float]], int, str]:
        """Push a scene; return CPU seconds, rows of (delta, t, E_hat), iterations and outcome."""
        assert self.process.stdin is not None and self.process.stdout is not None
        self.process.stdin.write(f"{which}\n")
        self.process.stdin.flush()
        seconds, rows, iterations, outcome = json.loads(self.process.stdout.readline())
        return seconds, rows, iterations, outcome

    def close(self) -> None:
        """End the process."""
        assert self.process.stdin is not None
        self.process.stdin.close()
        self.process.wait()


def apart(old: list[list[float]], new: list[list[float]]) -> tuple[int, float]:
    """Return how many end-shortenings two tables share, and the largest difference of t and E_hat there."""
    known = {row[0]: row for row in old}
    gaps = [
        max(abs(a - b) / max(1.0, abs(a)) for a, b in zip(known[row[0]], row, strict=True))
        for row in new
        if row[0] in known
    ]
    return len(gaps), max(gaps)


def main() -> int:
    """Print a line a scene."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--scenes", default=",".join(SCENES))
    parser.add_argument("--repeats", type=int, default=9)
    parser.add_argument("--file", action="store_true", help="push into a run file")
    args = parser.parse_args()
    names = args.scenes.split(",")
    files = [str((HERE / f"{name}.toml").resolve()) for name in names]
    good = True
    with tempfile.TemporaryDirectory() as folder:
        sources = (old_sources(Path(folder)), HERE.parent)
        workers = [Worker(one, files, file=args.file) for one in sources]
        for which, name in enumerate(names):
            for worker in workers:
                worker.push(which)  # compiles
            times: list[list[float]] = [[], []]
            for _ in range(args.repeats):
                results = [worker.push(which) for worker in workers]
                for one, result in zip(times, results, strict=True):
                    one.append(result[0])
            common, worst = apart(results[0][1], results[1][1])
            good &= worst <= SAME
            ratios = sorted(b / a for a, b in zip(*times, strict=True))
            least = min(times[1]) / min(times[0])
            print(
                f"{name:14s} CPU {min(times[0]):.3f} s, now {min(times[1]):.3f} s: least {least:.2f}, "
                f"median ratio {ratios[len(ratios) // 2]:.2f}; "
                f"iterations {results[0][2]}, now {results[1][2]}; "
                f"{common} common rows, {worst:.0e} apart; {results[1][3]}",
                flush=True,
            )
        for worker in workers:
            worker.close()
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main())
