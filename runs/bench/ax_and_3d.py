"""The branches Ax and 3D by derod and by AUTO-07p, in one run: time against error.

Errors are those of t (relative) and of delta (D) at three special points: Ax's pitchfork to 3D, Ax's fold,
and where 3D joins L2; exact is derod at an accuracy of 1e-11. derod traces all sheets of Ax, beyond the fold,
and estimates every point's error; AUTO stops at the fold, and is handed derod's first buckled state.
"""

from __future__ import annotations

import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

import derod
from bench import auto
from bench.auto import Settings

PATHS = ["Ax", "3D"]
EXACT = 1e-11
ACCURACIES = (1e-8,)  # looser ones take the same meshes and steps here
BEGIN = 0.1  # D, the end-shortening that AUTO starts at
CHOSEN = (
    Settings(15, 1e-4, 1.0),
    Settings(20, 1e-5, 1.0),
    Settings(30, 1e-6, 0.5),
    Settings(60, 1e-8, 0.5),
)
SCAN = [
    Settings(intervals, tolerance, step)
    for intervals in (15, 20, 30, 40, 60)
    for tolerance in (1e-4, 1e-5, 1e-6, 1e-7, 1e-8)
    for step in (0.5, 1.0, 2.0)
]
Points = list[tuple[float, float]]  # delta and t


class Found(NamedTuple):
    """One way to the two branches."""

    code: str
    settings: str
    cpu: float
    wall: float
    tension_error: float
    place_error: float
    missed: int  # of the three points


def own(scene: str, accuracy: float, stability: bool) -> tuple[Any, float, float]:
    """derod's branches, and (CPU, wall)."""
    cpu, wall = time.process_time(), time.perf_counter()
    found = derod.branch(scene, paths=PATHS, stability=stability, accuracy=accuracy)
    return found, time.process_time() - cpu, time.perf_counter() - wall


def own_points(found: Any) -> Points:
    """The three points of derod's branches."""
    ax, three = found["Ax"].bifurcations, found["3D"].bifurcations
    fold = next(row for row in ax if row["kind"] == b"fold")
    joint = [row for row in three if row["kind"] == b"pitchfork"][-1]
    return [
        (float(row["end_shortening"]), float(row["end_tension"])) for row in (ax[0], fold, joint)
    ]


def nearest(marked: list[auto.Special], kind: str, want: tuple[float, float]) -> tuple | None:
    """AUTO's point of a kind nearest to where one is, None where none is within 0.05 D."""
    near = [p for p in marked if p.kind == kind and abs(p.delta - want[0]) < 0.05]
    near = [p for p in near if abs(p.tension - want[1]) < 0.5]
    best = min(near, key=lambda p: abs(p.delta - want[0]), default=None)
    return None if best is None else (best.delta, best.tension)


def errors(points: list[tuple | None], exact: Points) -> tuple[float, float, int]:
    """The largest relative error of t, the largest of delta, and how many are missing."""
    pairs = [(got, want) for got, want in zip(points, exact, strict=True) if got is not None]
    tension = max((abs(got[1] / want[1] - 1) for got, want in pairs), default=np.nan)
    place = max((abs(got[0] - want[0]) for got, want in pairs), default=np.nan)
    return tension, place, len(points) - len(pairs)


def auto_points(answer: auto.Answer, exact: Points) -> list[tuple | None]:
    """AUTO's three points."""
    return [
        nearest(answer.ax, "BP", exact[0]),
        nearest(answer.ax, "LP", exact[1]),
        nearest(answer.three, "BP", exact[2]),
    ]


def beside(
    scene: str, folder: Path, settings: tuple[Settings, ...] = CHOSEN, repeats: int = 3
) -> list[Found]:
    """Both codes in turns: the least CPU and wall of each setting. Raises RuntimeError without AUTO."""
    program = auto.build(folder)
    reference, _, _ = own(scene, EXACT, False)
    exact, ax = own_points(reference), reference["Ax"]
    first = int(np.argmin(abs(ax.table["end_shortening"] - BEGIN)))
    start = auto.start_text(ax.state(first), ax.parameters)
    works: dict[tuple[str, str], Any] = {}
    for accuracy in ACCURACIES:
        for stability in (False, True):
            words = f"accuracy {accuracy:.0e}" + (", stability counted" if stability else "")
            works["derod", words] = lambda a=accuracy, s=stability: own(scene, a, s)
    for one in settings:
        works["AUTO-07p", str(one)] = lambda s=one: solved(program, start, s, exact)
    best: dict[tuple[str, str], tuple[Any, float, float]] = {}
    for _ in range(repeats):
        for key, work in works.items():
            answer, cpu, wall = work()
            _, least_cpu, least_wall = best.get(key, (None, np.inf, np.inf))
            best[key] = answer, min(cpu, least_cpu), min(wall, least_wall)
    out = []
    for (code, words), (answer, cpu, wall) in best.items():
        points = own_points(answer) if code == "derod" else auto_points(answer, exact)
        out.append(Found(code, words, cpu, wall, *errors(points, exact)))
    return out


def solved(
    program: Path, start: str, settings: Settings, exact: Points
) -> tuple[Any, float, float]:
    """AUTO's answer, CPU and wall."""
    answer = auto.solve(program, start, settings, exact[1][0])
    return answer, answer.cpu, answer.wall


def lines(scene: str, found: list[Found]) -> Iterator[str]:
    """The table of one scene."""
    yield f"\n{scene}\n"
    yield "| code | settings | error of t | of delta, D | points missed, of 3 | CPU, s | wall, s |"
    yield "|---|---|---|---|---|---|---|"
    for one in found:
        yield (
            f"| {one.code} | {one.settings} | {one.tension_error:.0e} | {one.place_error:.0e} | "
            f"{one.missed} | {one.cpu:.2f} | {one.wall:.2f} |"
        )
