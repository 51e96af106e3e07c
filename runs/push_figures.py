# ruff: noqa: E402 - threads are set before numpy is imported
"""Print what the push reaches: every figure of the push table, measured here and now.

    python runs/push_figures.py                    all rows (a few minutes)
    python runs/push_figures.py pushes elastica    some of them

Rows: pushes, step, elastica. Branch files that the errors are held against are computed once, by
``derod branch``, into runs/out. Explicit relaxation has its own: runs/explicit_figures.py.
"""

from __future__ import annotations

import os

for name in ("OPENBLAS_NUM_THREADS", "NUMBA_NUM_THREADS", "OMP_NUM_THREADS"):
    os.environ.setdefault(name, "1")

import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import derod

# isort: split
import numpy as np
from bench.branches import branches_of
from bench.elastica import elastica_errors, elastica_scene
from bench.stepping import implicit_step, pushed

from derod.branches.files.compare import compare
from derod.branches.files.record import open_branches
from derod.record import BaseRun

HERE = Path(__file__).parent
MESHES = (100, 200, 400)
REPEATS = 5


def planarity(run: BaseRun) -> np.ndarray:
    """Return how far each row is from a plane through the clamp axis, D."""
    return np.array([np.linalg.svd(run.positions(i)[:, :2])[1][1] for i in range(len(run))])


def transitions(run: BaseRun) -> str:
    """Return between which rows the rod leaves its plane or comes back, in units of pi."""
    flat = planarity(run) < 1e-6
    delta = run.table["end_shortening"] / np.pi
    changes = np.flatnonzero(flat[1:] != flat[:-1])
    return ", ".join(f"{delta[i]:.4f}-{delta[i + 1]:.4f}" for i in changes)


def pushes() -> Iterator[str]:
    """Both scenes on three meshes: endings, errors against the branches, time."""
    yield "scene, edges | rows | converged | unstable | worst error of t | of E_hat | shape, D | seconds"
    for name in ("paper-text", "paper-figures"):
        with open_branches(branches_of(name)) as branches:
            for edges in MESHES:
                scene = derod.load_scene(HERE / f"{name}.toml").replace({"mesh.edges": edges})
                run = derod.push(scene)
                seconds = []
                for _ in range(REPEATS):
                    began = time.perf_counter()
                    derod.push(scene)
                    seconds.append(time.perf_counter() - began)
                result = compare(run, branches)
                lost = int(np.sum(result["branch"] == ""))
                yield (
                    f"{name}, {edges} | {len(run)} to {run.table['end_shortening'][-1] / np.pi:.2f} pi | "
                    f"{bool(run.table['converged'].all())} | {run.table['unstable_modes'].max()} | "
                    f"{np.nanmax(result['tension_error']):.1e} | "
                    f"{np.nanmax(result['energy_error']):.1e} | "
                    f"{np.nanmax(result['shape_error']):.1e} | {min(seconds):.2f}"
                    + (f" | {lost} rows on no branch" if lost else "")
                )
                yield f"    out of or into the plane at {transitions(run)} pi"


def step() -> Iterator[str]:
    """The implicit step (assemble, factor, solve), at 200 edges."""
    scene = derod.load_scene(HERE / "paper-text.toml").replace(
        {"push.at": [], "push.stop": "0.5 pi"}
    )
    best = implicit_step(*pushed(scene))
    yield f"implicit step at 200 edges, line search included: {1e3 * best:.3f} ms"


def elastica() -> Iterator[str]:
    """The clamped-clamped elastica at an end shortening of 0.2 L."""
    before = None
    for edges in (50, 100, 200):
        errors = np.array(list(elastica_errors(derod.push(elastica_scene(edges))).values()))
        rate = "" if before is None else f", rates {np.log2(before / errors).round(2)}"
        yield f"elastica, {edges} edges: errors of load, mid-height {errors}{rate}"
        before = errors


ROWS: dict[str, Callable[[], Iterator[str]]] = {
    "pushes": pushes,
    "step": step,
    "elastica": elastica,
}


def main(names: list[str]) -> None:
    """Print the rows asked for."""
    for name in names or list(ROWS):
        for line in ROWS[name]():
            print(line, flush=True)


if __name__ == "__main__":
    main(sys.argv[1:])
