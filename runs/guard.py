# ruff: noqa: E402 - threads are set before numpy is imported
"""A guard against lost speed: what a push and a branch cost, in units of a reference kernel of the same run.

    python runs/guard.py            hold this checkout against runs/guard.json; exit code 1 on a loss
    python runs/guard.py --write    measure, and write runs/guard.json

The reference is a band's LDL^T in plain numba loops, which derod does not use: it is slow and fast where the
machine is. Work and reference run in turn, and the least CPU time of each counts. A ratio that is above its
bound, ALLOWED times the committed one, is measured again, up to ATTEMPTS times, and is a loss only if it
stays there. Kernels are compiled first, which is not measured.
"""

from __future__ import annotations

import os

for name in ("OPENBLAS_NUM_THREADS", "NUMBA_NUM_THREADS", "OMP_NUM_THREADS"):
    os.environ.setdefault(name, "1")

import argparse
import json
import sys
import time
from collections.abc import Callable
from pathlib import Path

import derod

# isort: split
import numpy as np
from bench.elastica import elastica_scene
from bench.stepping import disturbed, pushed
from numba import njit

from derod.equilibrium.loop import relax
from derod.equilibrium.methods import make_relaxer

HERE = Path(__file__).parent
COMMITTED = HERE / "guard.json"
ALLOWED = 1.5  # times the committed ratio: twice the scatter seen on a busy machine
ATTEMPTS = 3
ROUNDS = 5  # of work and reference in turn
SHORT = "0.3 pi"  # D, as far as the guarded pushes go
ROWS, HALF_WIDTH = 3200, 14

Work = Callable[[], object]


@njit
def reference(band: np.ndarray, lower: np.ndarray) -> float:
    """Factor a band, (n + w, w + 1) by lower diagonals, into ``lower``; return its last pivot."""
    rows, stride = band.shape
    lower[:] = band
    for j in range(rows - stride + 1):
        inverse = 1.0 / lower[j, 0]
        for k in range(1, stride):
            share = lower[j, k] * inverse
            for i in range(stride - k):
                lower[j + k, i] -= share * lower[j, k + i]
    return lower[rows - stride, 0]


def reference_work() -> Work:
    """Return the reference, some milliseconds of it."""
    rng = np.random.default_rng(0)
    band = rng.standard_normal((ROWS + HALF_WIDTH, HALF_WIDTH + 1))
    band[:, 0] += 50.0
    band[ROWS:] = 0.0
    lower = np.zeros_like(band)
    return lambda: [reference(band, lower) for _ in range(4)]


def short_push(edges: int) -> derod.Scene:
    """Return the paper's rod on a mesh, to be pushed a little way."""
    scene = derod.load_scene(HERE / "paper-text.toml")
    return scene.replace({"push.stop": SHORT, "push.at": [], "mesh.edges": edges})


def works() -> dict[str, Work]:
    """Return what is guarded, by name."""
    system, state = pushed(short_push(200))
    thrown, relaxer = disturbed(state), make_relaxer("implicit")
    small = elastica_scene(25)
    drops = {edges: short_push(edges) for edges in (50, 200, 800)}
    return {
        "linearisation, 200 edges": lambda: [system.linearise(state) for _ in range(20)],
        "relaxation, 200 edges": lambda: [relax(relaxer, system, thrown) for _ in range(5)],
        "elastica, 25 edges": lambda: [derod.push(small) for _ in range(5)],
        "push, 50 edges": lambda: derod.push(drops[50]),
        "push, 200 edges": lambda: derod.push(drops[200]),
        "push, 800 edges": lambda: derod.push(drops[800]),
        "branch Ax": lambda: derod.branch(HERE / "paper-text.toml", paths="Ax"),
    }


def seconds(work: Work) -> float:
    """Return the CPU time of one call, s."""
    clock = time.process_time()
    work()
    return time.process_time() - clock


def ratio(work: Work, unit: Work) -> float:
    """Return the least time of ``work`` over that of ``unit``, in turn."""
    least = [np.inf, np.inf]
    for _ in range(ROUNDS):
        least = [min(best, seconds(one)) for best, one in zip(least, (work, unit), strict=True)]
    return least[0] / least[1]


def main() -> int:
    """Measure, and compare or write."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--write", action="store_true", help=f"write {COMMITTED.name}")
    args = parser.parse_args()
    if not (args.write or COMMITTED.exists()):
        print(
            f"runs/{COMMITTED.name}: there is none; allowed: --write first, at a commit to be held to"
        )
        return 2
    clock = time.perf_counter()
    unit, guarded = reference_work(), works()
    for work in (unit, *guarded.values()):
        work()  # compiles
    print(f"compiled and warmed up in {time.perf_counter() - clock:.0f} s")
    clock = time.perf_counter()
    committed = {} if args.write else json.loads(COMMITTED.read_text())
    measured, lost = {}, []
    for name, work in guarded.items():
        bound = np.inf if args.write else ALLOWED * committed[name]
        value = ratio(work, unit)
        for _ in range(ATTEMPTS - 1):
            if value > bound:
                value = min(value, ratio(work, unit))
        measured[name] = round(value, 3)
        told = "" if args.write else f", {value / committed[name]:.2f} of the committed one"
        print(f"{name:26s} {value:8.3f} references{told}", flush=True)
        if value > bound:
            lost.append(name)
    if args.write:
        COMMITTED.write_text(json.dumps(measured, indent=2) + "\n")
    print(f"measured in {time.perf_counter() - clock:.0f} s")
    if lost:
        print(f"slower than {ALLOWED} times runs/{COMMITTED.name}: {', '.join(lost)}")
    return 1 if lost else 0


if __name__ == "__main__":
    sys.exit(main())
