# ruff: noqa: E402 - threads are set before numpy is imported
"""How the cost of a push grows: with edges, with its length, with the number of coils.

python runs/growth.py       (half a minute)
"""

from __future__ import annotations

import os

for name in ("OPENBLAS_NUM_THREADS", "NUMBA_NUM_THREADS", "OMP_NUM_THREADS"):
    os.environ.setdefault(name, "1")

import time
from collections.abc import Iterator
from pathlib import Path

import derod

# isort: split
import numpy as np

from derod.record import BaseRun

HERE = Path(__file__).parent
MESHES = (100, 200, 400, 800, 1600, 3200)


def timed(scene: derod.Scene, repeats: int = 3) -> tuple[BaseRun, float]:
    """Return a push and the least time it took, s."""
    best = np.inf
    for _ in range(repeats):
        clock = time.perf_counter()
        run = derod.push(scene)
        best = min(best, time.perf_counter() - clock)
    return run, best


def coils(positions: np.ndarray, arc_length: np.ndarray, menisci: tuple[float, float]) -> float:
    """Return the turns of the tangent inside the drop: its total turning angle over 2 pi."""
    tangent = np.diff(positions, axis=0)
    tangent /= np.linalg.norm(tangent, axis=1)[:, None]
    cosine = np.clip(np.sum(tangent[1:] * tangent[:-1], axis=1), -1, 1)
    inside = (arc_length[1:-1] > menisci[0]) & (arc_length[1:-1] < menisci[1])
    return float(np.arccos(cosine)[inside].sum() / (2 * np.pi))


def with_edges() -> Iterator[str]:
    """The same push on finer and finer meshes."""
    base = derod.load_scene(HERE / "paper-text.toml").replace({"push.at": [], "push.stop": "1 pi"})
    derod.push(base)
    yield "| edges | increments | iterations | s | us an iteration and edge |"
    yield "|---|---|---|---|---|"
    seconds = []
    for edges in MESHES:
        run, least = timed(base.replace({"mesh.edges": edges}))
        seconds.append(least)
        count = int(run.table["iterations"].sum())
        yield f"| {edges} | {len(run)} | {count} | {least:.3f} | {1e6 * least / count / edges:.2f} |"
    power = np.polyfit(np.log(MESHES[1:]), np.log(seconds[1:]), 1)[0]
    yield f"\nFrom 200 edges on the time grows like edges^{power:.2f}."


def with_coils() -> Iterator[str]:
    """A rod of l = 40 pushed further and further: push length and coils."""
    base = derod.load_scene(HERE / "paper-text.toml").replace(
        {"push.at": [], "rod.length": 40, "mesh.edges": 600}
    )
    yield "| pushed to, pi | coils | wetted length, D | increments | unstable modes | s | s a pi |"
    yield "|---|---|---|---|---|---|---|"
    for stop in (2, 4, 6, 8, 10):
        run, least = timed(base.replace({"push.stop": stop * np.pi}), repeats=1)
        last = run.table[-1]
        turns = coils(
            run.positions(-1), run.arc_length(-1), (last["meniscus_a"], last["meniscus_b"])
        )
        yield (
            f"| {last['end_shortening'] / np.pi:.2f} | {turns:.1f} | {last['wetted_length']:.1f} | "
            f"{len(run)} | {run.table['unstable_modes'].max()} | {least:.2f} | {least / stop:.2f} |"
        )


def main() -> None:
    """Print both tables."""
    for line in (*with_edges(), "", *with_coils()):
        print(line, flush=True)


if __name__ == "__main__":
    main()
