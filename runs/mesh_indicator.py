# ruff: noqa: E402 - threads are set before numpy is imported
"""Where the error of a mesh is, and how near the default grading is to the best one.

    python runs/mesh_indicator.py            (two minutes)

An indicator per edge: the rod is of fourth order, its energy's local error is of size l^5 |kappa''|^2,
kappa the curvature vector. A grid is the best for its size where that is the same on every edge. The
tables show which region has too few edges; the scan says what a better mesh would gain, as the worst error of
t and E_hat against a push on 1600 edges. Prints tables, draws docs/images/mesh-indicator.png.
"""

from __future__ import annotations

import os

for name in ("OPENBLAS_NUM_THREADS", "NUMBA_NUM_THREADS", "OMP_NUM_THREADS"):
    os.environ.setdefault(name, "1")

import itertools
from collections.abc import Iterator
from pathlib import Path

import derod

# isort: split
import matplotlib as mpl
import numpy as np

from derod.record import BaseRun

mpl.use("Agg")
import matplotlib.pyplot as plt

HERE = Path(__file__).parent
PLACES = (0.1, 0.5, 1.0, 2.0, 2.6)  # pi
LANDINGS = (0.1, 0.3, 0.6, 1.0)  # pi
SCAN = {
    "mesh.wetted_share": (0.5, 0.58, 0.65, 0.72),
    "mesh.layer": (0.25, 0.5, 0.75, 1.0),
    "mesh.inner_grading": (0.4, 0.9, 1.4),
}
EDGES, FINE = 100, 1600


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
        axis.set_ylabel(r"$l^5 |\kappa''|^2$, $K_0/D$")
        axis.grid(True, color="#dddddd", linewidth=0.6)
        axis.set_ylim(bottom=1e-9)
    handles, labels = axes[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside upper center", title="end-shortening", ncols=5)
    axes[-1].set_xlabel("arc length s, D")
    path.parent.mkdir(exist_ok=True)
    figure.savefig(path, dpi=120)


def scenes() -> dict[str, derod.Scene]:
    """Return the scenes of the scan: the paper's, and some that are far from them."""
    text, figures = (
        derod.load_scene(HERE / f"{name}.toml").replace(
            {"push.at": [f"{x} pi" for x in LANDINGS], "push.stop": "1.5 pi"}
        )
        for name in ("paper-text", "paper-figures")
    )
    return {
        "paper-text": text,
        "paper-figures": figures,
        "f_gamma = 100": text.replace({"drop.capillary_force": 100}),
        "f_gamma = 500": text.replace({"drop.capillary_force": 500}),
        "l = 40": text.replace({"rod.length": 40}),
        "end rotation 2 pi": text.replace({"clamps.end_rotation": "2 pi"}),
    }


def error_against(run: BaseRun, exact: BaseRun) -> float:
    """Return the worst relative error of t and E_hat at the landings."""
    worst = 0.0
    for place in (*LANDINGS, 1.5):
        a, b = (
            table[np.argmin(np.abs(table["end_shortening"] - place * np.pi))]
            for table in (run.table, exact.table)
        )
        assert a["end_shortening"] == b["end_shortening"], "a landing was missed"
        for name in ("end_tension", "energy_hat"):
            worst = max(worst, abs(a[name] - b[name]) / max(1.0, abs(b[name])))
    return worst


def scan_rows() -> Iterator[str]:
    """How much the best of all combinations of the keys would gain, scene by scene."""
    yield "| scene | error with the default mesh | of the best mesh | default / best | the best mesh |"
    yield "|---|---|---|---|---|"
    for name, scene in scenes().items():
        exact = derod.push(scene.replace({"mesh.edges": FINE}))
        coarse = scene.replace({"mesh.edges": EDGES})
        default = error_against(derod.push(coarse), exact)
        found = {
            values: error_against(
                derod.push(coarse.replace(dict(zip(SCAN, values, strict=True)))), exact
            )
            for values in itertools.product(*SCAN.values())
        }
        values, best = min(found.items(), key=lambda item: item[1])
        where = ", ".join(f"{k.split('.')[1]} {v}" for k, v in zip(SCAN, values, strict=True))
        yield f"| {name} | {default:.1e} | {best:.1e} | {default / best:.1f} | {where} |"


def main() -> None:
    """Print the tables and draw the figure."""
    runs = {}
    for name in ("paper-text", "paper-figures"):
        scene = derod.load_scene(HERE / f"{name}.toml").replace({"mesh.edges": EDGES})
        runs[name] = derod.push(scene)
        print(f"\n{name}, {EDGES} edges", *region_rows(runs[name]), sep="\n", flush=True)
    draw(runs, HERE.parent / "docs" / "images" / "mesh-indicator.png")
    print("")
    for line in scan_rows():
        print(line, flush=True)


if __name__ == "__main__":
    main()
