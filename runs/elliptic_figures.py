# ruff: noqa: E402 - threads are set before numpy is imported
"""Figures of elliptic relaxation: whole pushes beside implicit ones, and how gradients grow with the mesh.

    python runs/elliptic_figures.py                 all (some minutes, kernels compiled)
    python runs/elliptic_figures.py hard planar     those with these words in their names

Every push is made by both methods in turn, REPEATS times after one that is not timed; CPU seconds are
the least of each. States are compared at the landings, every tenth of pi, as long as both follow the same
branch: where one method is at an unstable state that the other has left (without noise, plain Newton steps
stay there) and after an increment in which the implicit push gained energy beyond the end's work (a wrong
step) there is nothing to compare; how many landings were compared is printed. An elliptic push that
gains energy has failed.

The exit code is the number of rows that are not as they must be: at most twice the implicit push's CPU,
t and E_hat equal to 1e-7 (relative), both ended as they should; and, for the scenes pushed on several
meshes, gradients that grow no faster than N^0.2.
"""

from __future__ import annotations

import os

for variable in ("OPENBLAS_NUM_THREADS", "NUMBA_NUM_THREADS", "OMP_NUM_THREADS"):
    os.environ.setdefault(variable, "1")

import sys
import time
from pathlib import Path
from typing import Any, NamedTuple

import derod

# isort: split
import numpy as np

from derod.record import BaseRun

HERE = Path(__file__).parent
METHODS = ("implicit", "elliptic")
MESHES = (50, 100, 200, 400, 800, 1600)
REPEATS = 3
MOST_CPU, MOST_DIFFERENCE, MOST_GROWTH = 2.0, 1e-7, 0.2
GAINED = 0.05  # K0/D beyond the work by the trapezoidal rule, whose error is a tenth of that


class Case(NamedTuple):
    """A push that both methods make."""

    name: str
    file: str
    meshes: tuple[int, ...]
    changes: dict[str, Any]


PLANAR = {"model.dimension": 2, "noise.amplitude": 0.0, "push.stop": "1.6 pi"}
CASES = (
    Case("paper-text", "paper-text", MESHES, {}),
    Case("paper-figures", "paper-figures", MESHES, {}),
    Case("hard wall, v0 = 1e-6", "paper-text", (200,), {"drop.wall_strength": 1e-6}),
    Case("f_gamma = 500", "paper-text", (200,), {"drop.capillary_force": 500}),
    Case("l = 20, R = 0", "l20-r0", (600,), {}),
    Case("l = 20, R = 2 pi", "l20-r2pi", (600,), {}),
    Case("planar, over Ax's fold, paper-text", "paper-text", (200,), PLANAR),
    Case("planar, over Ax's fold, paper-figures", "paper-figures", (200,), PLANAR),
)


class Row(NamedTuple):
    """Both pushes of a case on one mesh."""

    edges: int
    runs: tuple[BaseRun, BaseRun]
    cpu: tuple[float, float]
    tension: float  # largest relative differences at the landings
    energy: float
    compared: tuple[int, int]  # landings compared, landings of both

    @property
    def gradients(self) -> int:
        """Gradients of the elliptic push, all rows."""
        return int(self.runs[1].table["iterations"].sum())

    @property
    def good(self) -> bool:
        """Whether the row is as it must be."""
        return (
            all(run.ending is not None and run.ending.outcome == "completed" for run in self.runs)
            and all(bool(run.table["converged"].all()) for run in self.runs)
            and first_gain(self.runs[1]) == np.inf
            and self.cpu[1] <= MOST_CPU * self.cpu[0]
            and max(self.tension, self.energy) <= MOST_DIFFERENCE
        )


def scenes_of(case: Case, edges: int) -> list[derod.Scene]:
    """Return the scene of a case with landings every tenth of pi, by both methods."""
    scene = derod.load_scene(HERE / f"{case.file}.toml").replace(
        {"mesh.edges": edges, "push.at": [], **case.changes}
    )
    landings = np.arange(0.1, scene.push.stop[-1] / np.pi - 0.05, 0.1)
    at = [f"{place:.1f} pi" for place in landings]
    return [scene.replace({"push.at": at, "relax.method": method}) for method in METHODS]


def first_gain(run: BaseRun) -> float:
    """Return the end-shortening after which a run has gained energy beyond the end's work, or inf."""
    table = run.table
    delta, tension = table["end_shortening"], table["end_tension"]
    work = -0.5 * (tension[1:] + tension[:-1]) * np.diff(delta)
    gained = np.flatnonzero(np.diff(table["energy_total"]) - work > GAINED)
    return float(delta[gained[0]]) if gained.size else np.inf


def differences(runs: list[BaseRun]) -> tuple[float, float, tuple[int, int]]:
    """Return the largest relative differences of t and E_hat at landings, and how many were compared."""
    tables = [run.table[run.table["landing"].astype(bool)] for run in runs]
    first, second = (table[np.argsort(table["end_shortening"])] for table in tables)
    if not np.array_equal(first["end_shortening"], second["end_shortening"]):
        return np.inf, np.inf, (0, 0)
    same = first["unstable_modes"] == second["unstable_modes"]
    same &= first["end_shortening"] <= first_gain(runs[0])
    off = [
        float(abs(second[name] / first[name] - 1)[same].max())
        for name in ("end_tension", "energy_hat")
    ]
    return off[0], off[1], (int(same.sum()), same.size)


def measure(case: Case, edges: int) -> Row:
    """Push by both methods, in turn."""
    scenes = scenes_of(case, edges)
    runs = [derod.push(scene) for scene in scenes]
    cpu = [np.inf, np.inf]
    for _ in range(REPEATS):
        for k, scene in enumerate(scenes):
            clock = time.process_time()
            derod.push(scene)
            cpu[k] = min(cpu[k], time.process_time() - clock)
    return Row(edges, (runs[0], runs[1]), (cpu[0], cpu[1]), *differences(runs))


def events(run: BaseRun) -> str:
    """Return the kinds of a run's events, counted."""
    kinds = [event.kind for event in run.events]
    return ", ".join(f"{kinds.count(kind)} {kind}" for kind in dict.fromkeys(kinds))


def main(words: list[str]) -> int:
    """Print a line a push and the growth of gradients; return how many are not as they must be."""
    print(
        "| push | edges | implicit: rows, iterations | CPU s | elliptic: rows, gradients, most in a row"
        " | CPU s | ratio | t | E_hat | compared | events | |\n"
        "|---|---|---|---|---|---|---|---|---|---|---|---|"
    )
    failed = 0
    growth = []
    for case in CASES:
        if words and not any(word in case.name for word in words):
            continue
        rows = []
        for edges in case.meshes:
            row = measure(case, edges)
            rows.append(row)
            failed += not row.good
            implicit, elliptic = (run.table for run in row.runs)
            print(
                f"| {case.name} | {edges} | {len(implicit)}, {implicit['iterations'].sum()}"
                f" | {row.cpu[0]:.3f} | {len(elliptic)}, {row.gradients},"
                f" {elliptic['iterations'].max()} | {row.cpu[1]:.3f}"
                f" | {row.cpu[1] / row.cpu[0]:.2f} | {row.tension:.1e} | {row.energy:.1e}"
                f" | {row.compared[0]} of {row.compared[1]} | {events(row.runs[0])} / {events(row.runs[1])}"
                f" | {'as it must' if row.good else '**FAILED**'} |",
                flush=True,
            )
        if len(rows) > 1:
            slope = np.polyfit(
                np.log([row.edges for row in rows]), np.log([row.gradients for row in rows]), 1
            )[0]
            failed += slope > MOST_GROWTH
            growth.append(f"{case.name}: gradients grow like N^{slope:.2f}")
    print("\n" + "\n".join(growth))
    return failed


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
