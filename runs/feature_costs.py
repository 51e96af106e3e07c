# ruff: noqa: E402 - threads are set before numpy is imported
"""What each feature costs: a scene pays for what it has, and for nothing else.

    python runs/feature_costs.py       (a minute; more while kernels compile)

200 edges, states pushed to 0.2 pi (to 0.2 L without a drop), best of many steps.
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
from bench.elastica import elastica_scene
from bench.stepping import explicit_step, implicit_step, pushed

HERE = Path(__file__).parent
REPEATS = 5


def scenes() -> dict[str, derod.Scene]:
    """Return the scenes compared, the fullest first."""
    drop = derod.load_scene(HERE / "paper-text.toml").replace(
        {"push.at": [], "push.stop": "0.2 pi"}
    )
    bare = elastica_scene(200)
    return {
        "drop, in space": drop.replace({"push.stop": "0.4 pi"}),
        "drop, planar": drop.replace({"model.dimension": 2}),
        "no drop, in space": bare.replace({"model.dimension": 3}),
        "no drop, planar": bare,
    }


def steps() -> Iterator[str]:
    """Steps of each kind of scene, relative to the fullest."""
    yield "| scene (200 edges) | implicit step, us | | explicit step, us | |"
    yield "|---|---|---|---|---|"
    full: tuple[float, float] | None = None
    for name, scene in scenes().items():
        system, state = pushed(scene)
        own = implicit_step(system, state), explicit_step(system, state)
        full = full or own
        yield (
            f"| {name} | {1e6 * own[0]:.0f} | {own[0] / full[0]:.2f} | "
            f"{1e6 * own[1]:.1f} | {own[1] / full[1]:.2f} |"
        )


def best_push(scene: derod.Scene, path: Path | None) -> float:
    """Return the least time of a push, s."""
    best = float("inf")
    for _ in range(REPEATS):
        clock = time.perf_counter()
        derod.push(scene, path, overwrite=path is not None).close()
        best = min(best, time.perf_counter() - clock)
    return best


def recording() -> Iterator[str]:
    """A whole push in memory and into a file."""
    scene = derod.load_scene(HERE / "paper-text.toml")
    derod.push(scene)
    with tempfile.TemporaryDirectory() as folder:
        memory, file = best_push(scene, None), best_push(scene, Path(folder) / "run.h5")
    yield "| whole push of paper-text, 200 edges | s |"
    yield "|---|---|"
    yield f"| in memory | {memory:.3f} |"
    yield f"| into a file, every increment committed | {file:.3f} |"


def main() -> None:
    """Print both tables; streaming has its own study, viz/stream_cost.py."""
    for line in (*steps(), "", *recording()):
        print(line, flush=True)


if __name__ == "__main__":
    main()
