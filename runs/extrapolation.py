# ruff: noqa: E402 - threads are set before numpy is imported
"""What extrapolation gives: errors of the fine push, estimated and true, and of the extrapolated one.

    python runs/extrapolation.py

Both drop scenes, whole push, against the branches of the boundary-value problem; worst along the push.
"""

from __future__ import annotations

import os

for name in ("OPENBLAS_NUM_THREADS", "NUMBA_NUM_THREADS", "OMP_NUM_THREADS"):
    os.environ.setdefault(name, "1")

import tempfile
import time
from collections.abc import Iterator
from pathlib import Path

import derod

# isort: split
import numpy as np
from bench.branches import branches_of

from derod.branches.files.compare import compare
from derod.branches.files.record import open_branches
from derod.record import BaseRun

HERE = Path(__file__).parent
MESHES = (100, 200, 400, 800)
NAMES = {"end_tension": "t", "energy_hat": "E_hat"}


class Extrapolated:
    """A run seen through its extrapolated values."""

    def __init__(self, run: BaseRun) -> None:
        self.run, self.scene = run, run.scene
        self.table = run.table.copy()
        for name in NAMES:
            self.table[name] = run.extrapolated[name]

    def __len__(self) -> int:
        return len(self.run)

    def __getattr__(self, name: str) -> object:
        return getattr(self.run, name)


def worst(values: np.ndarray) -> float:
    """Return the largest of what is known."""
    return float(np.nanmax(values))


def rows() -> Iterator[str]:
    """A line a scene and mesh."""
    yield (
        "| scene | edges | error of t | estimated | of the extrapolated t | error of E_hat | estimated | "
        "of the extrapolated E_hat | rows compared | both pushes, s |"
    )
    yield "|---|---|---|---|---|---|---|---|---|---|"
    for name in ("paper-text", "paper-figures"):
        with open_branches(branches_of(name)) as branches:
            for edges in MESHES:
                scene = derod.load_scene(HERE / f"{name}.toml").replace({"mesh.edges": edges})
                derod.push(scene.replace({"push.stop": "0.01 pi", "push.at": []}))
                with tempfile.TemporaryDirectory() as folder:
                    clock = time.perf_counter()
                    run = derod.push(scene, Path(folder) / "run.h5", extrapolate=True)
                    seconds = time.perf_counter() - clock
                    fine, better = compare(run, branches), compare(Extrapolated(run), branches)
                    known = run.extrapolated
                    cells = []
                    for value, error in (("end_tension", "tension"), ("energy_hat", "energy")):
                        scale = np.maximum(np.abs(known[value]), 1.0)
                        cells += [
                            worst(fine[f"{error}_error"]),
                            worst(known[f"{value}_error"] / scale),
                            worst(better[f"{error}_error"]),
                        ]
                    compared = int(np.isfinite(known["end_tension"]).sum())
                    run.close()
                numbers = " | ".join(f"{cell:.1e}" for cell in cells)
                yield f"| {name} | {edges} | {numbers} | {compared} of {len(known)} | {seconds:.2f} |"


def main() -> None:
    """Print the table."""
    for line in rows():
        print(line, flush=True)


if __name__ == "__main__":
    main()
