# ruff: noqa: E402 - threads are set before numpy is imported
"""Where the error of a mesh is, and how near the default grading is to the best one.

    python runs/mesh_indicator.py            (two minutes)

An indicator per edge: the rod is of fourth order, its energy's local error is of size l^5 |kappa''|^2,
kappa the curvature vector. A grid is the best for its size where that is the same on every edge. The
tables show which region has too few edges; the scan says what that costs, as the worst error of t along the
push against the branches. Prints tables, draws runs/out/mesh-indicator.png.
"""

from __future__ import annotations

import os

for name in ("OPENBLAS_NUM_THREADS", "NUMBA_NUM_THREADS", "OMP_NUM_THREADS"):
    os.environ.setdefault(name, "1")

from collections.abc import Iterator
from pathlib import Path

import derod

# isort: split
import matplotlib as mpl
import numpy as np
from bench.branches import branches_of

from derod.branches.compare import compare
from derod.branches.record import open_branches
from derod.record import BaseRun
from derod.scene.tables import Mesh

mpl.use("Agg")
import matplotlib.pyplot as plt

HERE = Path(__file__).parent
PLACES = (0.1, 0.5, 1.0, 2.0, 2.6)  # pi
SCAN = {
    "mesh.wetted_share": (0.5, 0.58, 0.65, 0.72),
    "mesh.layer": (0.06, 0.12, 0.2),
    "mesh.inner_grading": (0.4, 0.9, 1.4),
}
EDGES = 100


def indicator(positions: np.ndarray, arc_length: np.ndarray) -> np.ndarray:
    """Return l^5 |kappa''|^2 of the edges that have two neighbours on both sides, (N-4,), K0/D."""
    edge = np.diff(positions, axis=0)
    tangent = edge / np.linalg.norm(edge, axis=1)[:, None]
    length = np.diff(arc_length)
    dual = 0.5 * (length[1:] + length[:-1])
    curvature = np.diff(tangent, axis=0) / dual[:, None]  # at the inner nodes
    slope = np.diff(curvature, axis=0) / length[1:-1, None]  # on the edges between
    second = np.diff(slope, axis=0) / dual[1:-1, None]  # at nodes again
    on_edges = 0.5 * (second[1:] + second[:-1])
    return length[2:-2] ** 5 * np.sum(on_edges**2, axis=1)


def region_rows(run: BaseRun) -> Iterator[str]:
    """Share of the indicator and of the edges, and how uneven it is, region by region."""
    yield "| pushed to, pi | outer, % of the error | inner, % | outer, max/mean | inner, max/mean |"
    yield "|---|---|---|---|---|"
    for place in PLACES:
        i = int(np.argmin(np.abs(run.table["end_shortening"] - place * np.pi)))
        row = run.table[i]
        eta = indicator(run.positions(i), run.arc_length(i))
        middle = 0.5 * (run.arc_length(i)[2:-3] + run.arc_length(i)[3:-2])
        inside = (middle > row["meniscus_a"]) & (middle < row["meniscus_b"])
        inner, outer = eta[inside], eta[~inside]
        whole = eta.sum()
        yield (
            f"| {place} | {100 * outer.sum() / whole:.0f} | {100 * inner.sum() / whole:.0f} | "
            f"{outer.max() / outer.mean():.0f} | {inner.max() / inner.mean():.0f} |"
        )


def draw(runs: dict[str, BaseRun], path: Path) -> None:
    """Draw the indicator along the rod."""
    figure, axes = plt.subplots(len(runs), 1, figsize=(9, 6.5), sharex=True, layout="constrained")
    for axis, (name, run) in zip(axes, runs.items(), strict=True):
        for place in PLACES:
            i = int(np.argmin(np.abs(run.table["end_shortening"] - place * np.pi)))
            s = run.arc_length(i)
            eta = indicator(run.positions(i), s)
            axis.semilogy(0.5 * (s[2:-3] + s[3:-2]), eta, ".-", label=f"{place} pi", linewidth=0.7)
        axis.set_title(f"{name}, {EDGES} edges", fontsize=10)
        axis.set_ylabel("l^5 |kappa''|^2, K0/D")
        axis.grid(True, color="#dddddd", linewidth=0.6)
        axis.set_ylim(bottom=1e-12)
    axes[0].legend(title="end-shortening", fontsize=8, ncols=5)
    axes[-1].set_xlabel("arc length s, D")
    path.parent.mkdir(exist_ok=True)
    figure.savefig(path, dpi=120)


def scan_rows() -> Iterator[str]:
    """The worst error of t along the push as one key at a time leaves its default."""
    yield "| key | value | worst error of t, paper-text | paper-figures |"
    yield "|---|---|---|---|"
    default = Mesh()
    for key, values in SCAN.items():
        for value in values:
            errors = []
            for scene_name in ("paper-text", "paper-figures"):
                scene = derod.load_scene(HERE / f"{scene_name}.toml")
                run = derod.push(scene.replace({"mesh.edges": EDGES, key: value}))
                with open_branches(branches_of(scene_name)) as branches:
                    errors.append(float(np.nanmax(compare(run, branches)["tension_error"])))
            mark = " (default)" if value == getattr(default, key.split(".")[1]) else ""
            yield f"| {key} | {value}{mark} | {errors[0]:.1e} | {errors[1]:.1e} |"


def main() -> None:
    """Print the tables and draw the figure."""
    runs = {}
    for name in ("paper-text", "paper-figures"):
        scene = derod.load_scene(HERE / f"{name}.toml").replace({"mesh.edges": EDGES})
        runs[name] = derod.push(scene)
        print(f"\n{name}, {EDGES} edges", *region_rows(runs[name]), sep="\n", flush=True)
    draw(runs, HERE / "out" / "mesh-indicator.png")
    print("")
    for line in scan_rows():
        print(line, flush=True)


if __name__ == "__main__":
    main()
