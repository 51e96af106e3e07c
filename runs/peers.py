# ruff: noqa: E402 - threads are set before numpy is imported
"""Peers and derod on the same problems, in the same run: time against error.

    python -m pip install '.[bench]'      (only for this; derod does not need them)
    python runs/peers.py                  all: [elastica] [drop] [step] [branches]
    python runs/peers.py tune             the scan that PyElastica's settings were chosen from (ten minutes)
    python runs/peers.py tune-elastica    that of the other peers on the elastica (three minutes)
    python runs/peers.py tune-branches    that of AUTO-07p (ten minutes)

Prints tables and writes runs/out/peers.csv. What each is given is told at the head of its file in
runs/bench: pyelastica, opensees, exudyn_cable, mujoco_cable, collocation, auto. A peer that is not here is
named and left out; AUTO needs gfortran, and the sources of bifpy, which pip downloads. The drop scene is
runs/paper-text.toml, pushed to 0.5 pi; exact is derod at 800 edges, which the branches of the boundary-value
problem confirm to 1e-7 (runs/push_figures.py). Both codes go there as fast as they can: PyElastica in one
smooth push, derod in increments of up to 0.25 pi. An error is the larger of those of t and E_hat: each alone
is small by chance on some settings.
"""

from __future__ import annotations

import os

for name in ("OPENBLAS_NUM_THREADS", "NUMBA_NUM_THREADS", "OMP_NUM_THREADS"):
    os.environ.setdefault(name, "1")

import itertools
import sys
import time
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import Any

import derod

# isort: split
import numpy as np
from bench import ax_and_3d, small
from bench.elastica import elastica_errors, elastica_scene, exact_elastica
from bench.row import Row, larger_error, write_csv
from explicit_figures import time_per_step

HERE = Path(__file__).parent
SHORTENING = 0.5 * np.pi
DROP = "paper-text to 0.5 pi"
REPEATS = 5
TURNS = 25  # of codes that take milliseconds


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
    return scene.replace(
        {"push.stop": SHORTENING, "push.at": [], "push.max_step": "0.25 pi", "mesh.edges": edges}
    )


def own_row(problem: str, edges: int, wall: float, cpu: float, run, errors) -> Row:
    """Return the row of a derod push."""
    table = run.table
    return Row(
        problem, "derod", "implicit", edges, "default", wall, cpu, len(run),
        int(table["iterations"].sum()), **errors,
    )  # fmt: skip


def has_pyelastica() -> bool:
    """Whether PyElastica is here; a line where it is not."""
    try:
        import elastica as _  # noqa: F401
    except ImportError:
        print("PyElastica: cannot be imported: python -m pip install pyelastica", file=sys.stderr)
        return False
    return True


def interleaved_elastica() -> Iterator[Row]:
    """derod and the peers that solve for the equilibrium, in turns."""
    peers = dict(small.installed())
    asked: list[tuple[str, Any]] = [("derod", elastica_scene(edges)) for edges in (25, 50, 100)]
    works: list[Callable[[], Any]] = [lambda s=scene: derod.push(s) for _, scene in asked]
    for name, module in peers.items():
        for values in small.CHOSEN[name]:
            settings = module.Settings(*values)
            asked.append((name, settings))
            works.append(lambda m=module, s=settings: m.solve(s))
    with small.quiet():
        found = small.least(works, TURNS)
    for (name, settings), (answer, wall, cpu) in zip(asked, found, strict=True):
        if name == "derod":
            edges = settings.mesh.edges
            yield own_row("elastica", edges, wall, cpu, answer, elastica_errors(answer))
        else:
            yield small.row_of(name, settings, answer, wall, cpu)


def elastica() -> Iterator[Row]:
    """The clamped-clamped elastica at an end shortening of 0.2 L."""
    yield from interleaved_elastica()
    if not has_pyelastica():
        return
    from bench.pyelastica import COMPILE, Problem, Settings, solve

    load, height = exact_elastica()
    problem = Problem(1.0, 1.0, 0.2, planar=True, courant=0.5)
    solve(problem, COMPILE)
    for elements, rise, hold in ((25, 0.5, 2.0), (50, 0.5, 2.0), (100, 0.5, 2.0)):
        settings = Settings(elements, rise, hold, 10.0)
        answer, wall, cpu = timed(lambda s=settings: solve(problem, s))
        yield Row(
            "elastica", "PyElastica", "damped dynamics", elements, "uniform", wall, cpu,
            iterations=answer.steps, tension_error=abs(-answer.tension / load - 1),
            shape_error=abs(answer.height - height), note=str(settings),
        )  # fmt: skip


TUNED = (  # elements, push, hold, damping, stiffness: the best of ``tune`` at rising cost
    (100, 3, 3, 3, 1e4),
    (100, 3, 3, 3, 3e4),
    (100, 3, 3, 6, 1e5),
    (200, 3, 3, 3, 1e5),
    (400, 6, 6, 3, 1e5),
)
SCAN = {
    "elements": (50, 100, 200),
    "times": ((3, 3), (6, 6), (3, 9)),
    "damping": (1, 3, 6),
    "stiffness": (1e4, 3e4, 1e5),
}


def peer_rows(chosen: Iterable[tuple]) -> Iterator[Row]:
    """PyElastica in the drop, at 0.5 pi, with each of the settings."""
    from bench.pyelastica import COMPILE, Problem, Settings, solve

    exact = derod.push(drop_scene(800)).table[-1]
    scene = drop_scene(100)
    parameters = (
        scene.drop.wall_strength, scene.drop.wall_softness, scene.drop.capillary_force,
    )  # fmt: skip
    problem = Problem(scene.rod.length, scene.rod.twisting, SHORTENING, parameters)
    solve(problem, COMPILE)
    for values in chosen:
        settings = Settings(*values)
        answer, wall, cpu = timed(lambda s=settings: solve(problem, s))
        energy = answer.energy - exact["energy_total"]
        yield Row(
            DROP, "PyElastica", "damped dynamics", settings.elements, "uniform", wall, cpu,
            iterations=answer.steps, tension_error=abs(answer.tension / exact["end_tension"] - 1),
            energy_error=abs(energy / exact["energy_hat"]),
            note=f"{settings}, left moving at {answer.speed:.0e}",
        )  # fmt: skip


def drop() -> Iterator[Row]:
    """The paper's rod in its drop, at 0.5 pi."""
    exact = derod.push(drop_scene(800)).table[-1]
    for edges in (24, 32, 40, 50, 100, 200):
        scene = drop_scene(edges)
        derod.push(scene)
        run, wall, cpu = quickest(lambda scene=scene: derod.push(scene))
        last = run.table[-1]
        errors = {
            "tension_error": abs(last["end_tension"] / exact["end_tension"] - 1),
            "energy_error": abs(last["energy_hat"] / exact["energy_hat"] - 1),
        }
        yield own_row(DROP, edges, wall, cpu, run, errors)
    if has_pyelastica():
        yield from peer_rows(TUNED)


def tune() -> Iterator[str]:
    """The scan of PyElastica's settings, best first among equal costs."""
    rows = peer_rows(
        (elements, *times, damping, stiffness)
        for stiffness, elements, times, damping in itertools.product(
            SCAN["stiffness"], SCAN["elements"], SCAN["times"], SCAN["damping"]
        )
    )
    yield "| elements | settings | error of t | of E_hat | wall, s | on the front |"
    yield "|---|---|---|---|---|---|"
    best = np.inf
    for row in sorted(rows, key=lambda row: row.wall):
        front = error_of(row) < best
        best = min(best, error_of(row))
        yield (
            f"| {row.edges} | {row.note} | {row.tension_error:.1e} | {row.energy_error:.1e} | "
            f"{row.wall:.2f} | {'yes' if front else ''} |"
        )


def error_of(row: Row) -> float:
    """Return the error that a row is judged by."""
    return larger_error(row.tension_error, row.energy_error)


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
    own = sorted((row for row in rows if row.code == "derod"), key=lambda row: row.wall)
    yield (
        "\n| peer, elements | its error | its CPU, s | derod at its error: CPU | wall | "
        "at a tenth of it: CPU |"
    )
    yield "|---|---|---|---|---|---|"
    for peer in (row for row in rows if row.code != "derod"):
        cells = [f"| {peer.code}, {peer.edges} | {error_of(peer):.1e} | {peer.cpu:.3g} |"]
        for share, clocks in ((1.0, ("cpu", "wall")), (0.1, ("cpu",))):
            better = (row for row in own if error_of(row) <= share * error_of(peer))
            best = next(better, None)
            cells += [
                "no such mesh here |" if best is None else ratio(peer, best, clock)
                for clock in clocks
            ]
        yield " ".join(cells)


def ratio(peer: Row, own: Row, clock: str) -> str:
    """How much faster or slower derod is; a peer within a factor of two is said to be close."""
    times = getattr(peer, clock) / getattr(own, clock)
    word = "faster" if times >= 1 else "slower"
    close = ", close" if 0.5 < times < 2 else ""
    size = max(times, 1 / times)
    digits = ".1f" if size < 9.95 else ".0f"
    return f"{own.edges} edges, {size:{digits}} times {word}{close} |"


def branches() -> Iterator[str]:
    """Ax and 3D beside AUTO-07p."""
    for scene in ("paper-text", "paper-figures"):
        try:
            yield from ax_and_3d.lines(scene, ax_and_3d.beside(scene, HERE / "out" / "auto"))
        except RuntimeError as error:
            yield f"AUTO-07p: cannot be built: {error}"
            return


def tune_branches() -> Iterator[str]:
    """The scan of AUTO's settings."""
    for scene in ("paper-text", "paper-figures"):
        scan = tuple(ax_and_3d.SCAN)
        found = ax_and_3d.beside(scene, HERE / "out" / "auto", scan, repeats=1)
        yield from ax_and_3d.lines(scene, sorted(found, key=lambda one: one.cpu))


def tune_elastica() -> Iterator[str]:
    """The fronts of the scans on the elastica."""
    yield "| code | elements | settings | error of t | of shape, L | CPU, s |"
    yield "|---|---|---|---|---|---|"
    for name, module in small.installed():
        for row in small.tuned(name, module):
            yield (
                f"| {name} | {row.edges} | {row.note} | {row.tension_error:.1e} | "
                f"{row.shape_error:.1e} | {row.cpu:.2g} |"
            )


def main(names: list[str]) -> int:
    """Run what is asked for; return an exit code."""
    scans = {"tune": tune, "tune-elastica": tune_elastica, "tune-branches": tune_branches}
    studies = {"elastica", "drop", "step", "branches"}
    if unknown := sorted(set(names) - studies - set(scans)):
        print(f"{unknown[0]}: allowed: {', '.join([*sorted(studies), *scans])}", file=sys.stderr)
        return 2
    for name in names:
        if name in scans:
            for line in scans[name]():
                print(line, flush=True)
            return 0
    rows: list[Row] = []
    for name, study in (("elastica", elastica), ("drop", drop)):
        if not names or name in names:
            found = list(study())
            print(f"\n### {name}\n", *table(found), sep="\n", flush=True)
            rows += found
    if rows:
        write_csv(HERE / "out" / "peers.csv", rows)
    if not names or "branches" in names:
        print("\n### branches", flush=True)
        for line in branches():
            print(line, flush=True)
    if (not names or "step" in names) and has_pyelastica():
        print("\n### step\n", *step(), sep="\n", flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
