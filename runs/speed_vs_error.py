# ruff: noqa: E402 - threads are set before numpy is imported
"""Speed against error: both drop scenes and the elastica, over meshes, gradings and methods.

    python runs/speed_vs_error.py            all (about three minutes on a quiet machine)
    python runs/speed_vs_error.py --quick    fewer meshes
    python runs/speed_vs_error.py --draw     the figure again, from what was measured last

Every measurement has a process of its own, so that its peak memory is its own; kernels are compiled
before. Errors are the worst along the push, against the branches of the boundary-value problem, or the
elastica's closed form. Writes runs/out/speed_vs_error.csv, the figure docs/images/work-precision.png
(with PyElastica's points where runs/out/peers.csv is there), and prints the table.

The explicit methods take 10^4 to 10^5 steps an increment: they are measured on two coarse meshes and
to 0.1 pi, in three increments.
"""

from __future__ import annotations

import os

for name in ("OPENBLAS_NUM_THREADS", "NUMBA_NUM_THREADS", "OMP_NUM_THREADS"):
    os.environ.setdefault(name, "1")

import argparse
import csv
import json
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import derod

# isort: split
import numpy as np
from bench.branches import branches_of
from bench.elastica import elastica_errors, elastica_scene
from bench.row import Row, larger_error, write_csv

HERE = Path(__file__).parent
MEASURED = HERE / "out" / "speed_vs_error.csv"
MESHES = (50, 100, 200, 400, 800, 1600)
QUICK = (50, 100, 200)
GRADINGS: dict[str, dict[str, Any]] = {
    "default": {},
    "uniform outside": {"mesh.layer": 500.0},
    "uniform inside": {"mesh.inner_grading": 0.0},
    "half the edges inside": {"mesh.wetted_share": 0.5},
}
SHORT = {
    "push.start": "0.02 pi",
    "push.stop": "0.1 pi",
    "push.at": [],
    "push.max_step": "0.04 pi",
}
REPEATS = 3


def scene_of(problem: str, changes: dict[str, Any]) -> derod.Scene:
    """Return the scene of a measurement."""
    if problem == "elastica":
        return elastica_scene(changes["mesh.edges"])
    return derod.load_scene(HERE / f"{problem.split()[0]}.toml").replace(changes)


def measure_here(problem: str, changes: dict[str, Any], path: str) -> dict[str, float]:
    """Push a few times in memory and once into a file; return what that cost."""
    scene = scene_of(problem, changes)
    derod.push(scene.replace({"push.stop": scene.push.start * 1.01}))  # loads the kernels
    best = (np.inf, np.inf)
    for _ in range(REPEATS if scene.relax.method == "implicit" else 1):
        wall, cpu = time.perf_counter(), time.process_time()
        run = derod.push(scene)
        best = min(best, (time.perf_counter() - wall, time.process_time() - cpu))
    memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    derod.push(scene, path, overwrite=True).close()
    iterations = int(run.table["iterations"].sum())
    return {
        "wall": best[0], "cpu": best[1], "increments": len(run), "iterations": iterations,
        "memory": memory, "note": str(run.ending.outcome),
    }  # fmt: skip


def errors_of(problem: str, path: Path) -> dict[str, float]:
    """Return the worst errors of a recorded push."""
    from derod.branches.files.compare import compare
    from derod.branches.files.record import open_branches

    with derod.open_run(path) as run:
        if problem == "elastica":
            return elastica_errors(run)
        with open_branches(branches_of(problem.split()[0])) as branches:
            result = compare(run, branches)
    names = ("tension_error", "energy_error", "shape_error")
    return {name: float(np.nanmax(result[name])) for name in names}


def measured(problem: str, method: str, edges: int, grading: str) -> Row:
    """Measure in a process of its own."""
    changes = {"mesh.edges": edges, "relax.method": method, **GRADINGS[grading]}
    if problem.endswith("to 0.1 pi"):
        changes |= SHORT
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "run.h5"
        job = json.dumps([problem, changes, str(path)])
        done = subprocess.run(
            [sys.executable, __file__, "--job", job], capture_output=True, text=True
        )
        if done.returncode:
            raise RuntimeError(f"{problem}, {method}, {edges} edges: {done.stderr}")
        cost = json.loads(done.stdout.splitlines()[-1])
        errors = errors_of(problem, path)
    return Row(problem, "derod", method, edges, grading, **cost, **errors)


def study(meshes: tuple[int, ...]) -> Iterator[Row]:
    """All measurements."""
    for edges in meshes:
        yield measured("elastica", "implicit", edges, "default")
    for scene in ("paper-text", "paper-figures"):
        for edges in meshes:
            yield measured(scene, "implicit", edges, "default")
        for grading in list(GRADINGS)[1:]:
            yield measured(scene, "implicit", 200, grading)
    for method in ("implicit", "fire", "kinetic"):
        for edges in (50, 100):
            yield measured("paper-text to 0.1 pi", method, edges, "default")


def table(rows: list[Row]) -> Iterator[str]:
    """The rows in markdown."""
    yield (
        "| problem | method | edges | grading | wall, s | CPU, s | increments | iterations | "
        "error of t | of E_hat | of shape, D | peak MB |"
    )
    yield "|---|---|---|---|---|---|---|---|---|---|---|---|"
    for row in rows:
        yield (
            f"| {row.problem} | {row.method} | {row.edges} | {row.grading} | {row.wall:.3g} | "
            f"{row.cpu:.3g} | {row.increments} | {row.iterations} | {row.tension_error:.1e} | "
            f"{row.energy_error:.1e} | {row.shape_error:.1e} | {row.memory:.0f} |"
        )


def draw(path: Path) -> None:
    """Draw wall-clock against the larger of both errors, a panel a problem."""
    import matplotlib as mpl

    mpl.use("Agg")
    import matplotlib.pyplot as plt

    with MEASURED.open() as file:
        points = list(csv.DictReader(file))
    peers = HERE / "out" / "peers.csv"
    if peers.exists():
        with peers.open() as file:
            points += [row for row in csv.DictReader(file) if row["code"] != "derod"]
    text = "paper-text"
    panels = {
        "elastica, to 0.2 L": ("elastica",),
        "drop, v0 = 2e-4, whole push\n(PyElastica: to 0.5 pi; fire, kinetic: to 0.1 pi)": (
            text, f"{text} to 0.5 pi", f"{text} to 0.1 pi",
        ),
        "drop, v0 = 2e-2, whole push": ("paper-figures",),
    }  # fmt: skip
    colours = {
        "derod, implicit": "#0072b2", "derod, fire": "#009e73", "derod, kinetic": "#e69f00",
        "derod, other gradings": "#56b4e9", "PyElastica": "#d55e00",
    }  # fmt: skip
    figure, axes = plt.subplots(1, 3, figsize=(13, 4.4), sharey=True, layout="constrained")
    for axis, (title, problems) in zip(axes, panels.items(), strict=True):
        for label, colour in colours.items():
            own = [p for p in points if p["problem"] in problems and label_of(p) == label]
            if not own:
                continue
            line = "" if label in ("derod, other gradings", "PyElastica") else "-"
            x = [larger_error(float(p["tension_error"]), float(p["energy_error"])) for p in own]
            y = [float(p["wall"]) for p in own]
            axis.loglog(x, y, "o" + line, color=colour, label=label, markersize=5)
            for p, a, b in zip(own, x, y, strict=True):
                axis.annotate(
                    str(p["edges"]), (a, b), xytext=(4, 4), textcoords="offset points", fontsize=7
                )
        axis.set_title(title, fontsize=9)
        axis.set_xlabel("worst relative error of t and E_hat")
        axis.grid(True, which="major", color="#dddddd", linewidth=0.6)
        axis.invert_xaxis()
    axes[0].set_ylabel("wall-clock, s (one core, kernels compiled)")
    handles = {}
    for axis in axes:
        handles |= dict(zip(*axis.get_legend_handles_labels()[::-1], strict=True))
    figure.legend(handles.values(), handles.keys(), loc="outside lower center", ncols=5)
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path, dpi=130)


def label_of(point: dict[str, Any]) -> str:
    """Return the curve that a point belongs to; shorter pushes are shown for what has no whole one."""
    if point["code"] != "derod":
        return point["code"]
    if point["grading"] != "default":
        return "derod, other gradings"
    if point["method"] == "implicit" and " to " in point["problem"]:
        return ""
    return f"derod, {point['method']}"


def main() -> None:
    """Measure, write, draw, print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="fewer meshes")
    parser.add_argument(
        "--figure", type=Path, default=HERE.parent / "docs" / "images" / "work-precision.png"
    )
    parser.add_argument("--draw", action="store_true", help="draw what was measured last")
    parser.add_argument("--job", help=argparse.SUPPRESS)
    args = parser.parse_args()
    if args.job:
        print(json.dumps(measure_here(*json.loads(args.job))))
        return
    if args.draw:
        draw(args.figure)
        return
    derod.push(elastica_scene(50))
    for name in ("paper-text", "paper-figures"):
        branches_of(name)
    rows = []
    for row in study(QUICK if args.quick else MESHES):
        rows.append(row)
        print(f"{row.problem}, {row.method}, {row.edges}, {row.grading}", file=sys.stderr)
    write_csv(MEASURED, rows)
    draw(args.figure)
    print(*table(rows), sep="\n")


if __name__ == "__main__":
    main()
