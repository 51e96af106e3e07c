# ruff: noqa: E402 - threads are set before numpy is imported
"""PyElastica and derod on the same problems, in the same run: work, precision, time per step.

    python -m pip install pyelastica      (only for this; derod does not need it)
    python runs/peers.py [elastica] [drop] [step]

Prints tables and writes runs/out/peers.csv. What PyElastica is given: runs/bench/pyelastica.py. The
drop scene is runs/paper-text.toml, pushed to 0.5 pi; exact is derod at 800 edges, which the branches
of the boundary-value problem confirm to 1e-7 (runs/push_figures.py).
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
from bench.elastica import elastica_errors, elastica_scene, exact_elastica
from bench.row import Row, write_csv
from explicit_figures import time_per_step

HERE = Path(__file__).parent
SHORTENING = 0.5 * np.pi
REPEATS = 5


def timed(work: Callable[[], object]) -> tuple[object, float, float]:
    """Return (result, wall-clock, CPU time), s."""
    wall, cpu = time.perf_counter(), time.process_time()
    result = work()
    return result, time.perf_counter() - wall, time.process_time() - cpu


def quickest(work: Callable[[], object]) -> tuple[object, float, float]:
    """Return the quickest of several runs."""
    return min((timed(work) for _ in range(REPEATS)), key=lambda done: done[1])


def drop_scene(edges: int) -> derod.Scene:
    """Return the paper's rod, to be pushed to 0.5 pi."""
    scene = derod.load_scene(HERE / "paper-text.toml")
    return scene.replace({"push.stop": SHORTENING, "push.at": [], "mesh.edges": edges})


def own_row(problem: str, edges: int, wall: float, cpu: float, run, errors) -> Row:
    """Return the row of a derod push."""
    table = run.table
    return Row(
        problem, "derod", "implicit", edges, "default", wall, cpu, len(run),
        int(table["iterations"].sum()), **errors,
    )  # fmt: skip


def elastica() -> Iterator[Row]:
    """The clamped-clamped elastica at an end shortening of 0.2 L."""
    from bench.pyelastica import COMPILE, Problem, Settings, solve

    for edges in (25, 50, 100):
        scene = elastica_scene(edges)
        derod.push(scene)
        run, wall, cpu = quickest(lambda scene=scene: derod.push(scene))
        yield own_row("elastica", edges, wall, cpu, run, elastica_errors(run))
    load, height = exact_elastica()
    problem = Problem(1.0, 1.0, 0.2, planar=True, courant=0.5)
    solve(problem, COMPILE)
    for elements, rise, hold in ((25, 0.5, 2.0), (50, 0.5, 2.0), (100, 0.5, 2.0)):
        settings = Settings(elements, rise, hold, 10.0)
        answer, wall, cpu = timed(lambda s=settings: solve(problem, s))
        yield Row(
            "elastica", "PyElastica", "damped dynamics", elements, "uniform", wall, cpu,
            iterations=answer.steps, tension_error=abs(-answer.tension / load - 1),
            shape_error=abs(answer.height - height), note=f"push {rise}, hold {hold}",
        )  # fmt: skip


def drop() -> Iterator[Row]:
    """The paper's rod in its drop, at 0.5 pi."""
    from bench.pyelastica import COMPILE, Problem, Settings, solve

    exact = derod.push(drop_scene(800)).table[-1]
    problem_name = "paper-text to 0.5 pi"
    for edges in (50, 100, 200):
        scene = drop_scene(edges)
        derod.push(scene)
        run, wall, cpu = quickest(lambda scene=scene: derod.push(scene))
        last = run.table[-1]
        errors = {
            "tension_error": abs(last["end_tension"] / exact["end_tension"] - 1),
            "energy_error": abs(last["energy_hat"] / exact["energy_hat"] - 1),
        }
        yield own_row(problem_name, edges, wall, cpu, run, errors)
    scene = drop_scene(100)
    parameters = (
        scene.drop.wall_strength, scene.drop.wall_softness, scene.drop.capillary_force,
    )  # fmt: skip
    problem = Problem(scene.rod.length, scene.rod.twisting, SHORTENING, parameters)
    solve(problem, COMPILE)
    for elements, rise, hold in (
        (100, 6, 6),
        (100, 15, 15),
        (200, 6, 6),
        (200, 15, 15),
        (400, 6, 6),
    ):
        settings = Settings(elements, rise, hold, 3.0)
        answer, wall, cpu = timed(lambda s=settings: solve(problem, s))
        energy = answer.energy - exact["energy_total"]
        yield Row(
            problem_name, "PyElastica", "damped dynamics", elements, "uniform", wall, cpu,
            iterations=answer.steps, tension_error=abs(answer.tension / exact["end_tension"] - 1),
            energy_error=abs(energy / exact["energy_hat"]),
            note=f"push {rise}, hold {hold}, left moving at {answer.speed:.0e}",
        )  # fmt: skip


def step() -> Iterator[str]:
    """One explicit step, the drop included."""
    from bench.pyelastica import Problem
    from bench.pyelastica import time_per_step as peer_step

    problem = Problem(10.0, 0.9, SHORTENING, (2e-4, 0.1, 20.0))
    yield "| edges | PyElastica, us a step | derod (FIRE), us a step | ratio |"
    yield "|---|---|---|---|"
    for edges in (100, 400, 800):
        peer, own = peer_step(problem, edges), time_per_step(edges, "fire")
        yield f"| {edges} | {1e6 * peer:.1f} | {1e6 * own:.1f} | {peer / own:.1f} |"


def table(rows: list[Row]) -> Iterator[str]:
    """The rows, and how they compare at equal error."""
    yield "| code | edges | steps or iterations | error of t | of E_hat | of shape, D | wall, s | CPU, s | |"
    yield "|---|---|---|---|---|---|---|---|---|"
    for row in rows:
        yield (
            f"| {row.code} | {row.edges} | {row.iterations} | {row.tension_error:.1e} | "
            f"{row.energy_error:.1e} | {row.shape_error:.1e} | {row.wall:.3g} | {row.cpu:.3g} | {row.note} |"
        )
    own = [row for row in rows if row.code == "derod"]
    for peer in (row for row in rows if row.code != "derod"):
        better = [row for row in own if row.tension_error <= 0.1 * peer.tension_error]
        if better:
            best = min(better, key=lambda row: row.wall)
            yield (
                f"\nPyElastica with {peer.edges} elements ({peer.note}): derod with {best.edges} edges is "
                f"{peer.wall / best.wall:.0f} times faster, its error of t "
                f"{peer.tension_error / best.tension_error:.0f} times smaller."
            )


def main(names: list[str]) -> int:
    """Run what is asked for; return an exit code."""
    try:
        import elastica as _  # noqa: F401
    except ImportError:
        print("PyElastica is not installed: python -m pip install pyelastica", file=sys.stderr)
        return 2
    rows: list[Row] = []
    for name, study in (("elastica", elastica), ("drop", drop)):
        if not names or name in names:
            found = list(study())
            print(f"\n### {name}\n", *table(found), sep="\n", flush=True)
            rows += found
    if rows:
        write_csv(HERE / "out" / "peers.csv", rows)
    if not names or "step" in names:
        print("\n### step\n", *step(), sep="\n", flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
