# ruff: noqa: E402 - threads are set before numpy is imported
"""Print what the branches reach: every figure of the branch table, measured here and now.

    python runs/branch_figures.py                 all rows (some minutes)
    python runs/branch_figures.py speed compare   some of them

Rows: paths, speed, robustness, points, long, compare, others. Threads are set to one. Outputs go to
runs/out.
"""

from __future__ import annotations

import os

for name in ("OPENBLAS_NUM_THREADS", "NUMBA_NUM_THREADS", "OMP_NUM_THREADS"):
    os.environ.setdefault(name, "1")

import statistics
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path

import derod

# isort: split
import numpy as np

from derod.branches.files.record import open_branches
from derod.branches.files.writing import write_branches
from derod.branches.half_rod import closure as col
from derod.branches.half_rod.mirror import LOOP_EVEN, STRAIGHT_LOOP
from derod.branches.half_rod.parameters import Parameters
from derod.branches.paths.arc import Control, Point, Tracer, frozen
from derod.branches.paths.beginning import buckled
from derod.branches.paths.catalogue import Catalogue
from derod.branches.paths.compute import compute_branches
from derod.branches.paths.error import halving_error
from derod.branches.paths.newton import settle
from derod.branches.paths.special import fold_function, locate
from derod.branches.paths.tracing import collect
from derod.scene import load_scene

HERE = Path(__file__).parent
OUT = HERE / "out"
SCENES = ("paper-text", "paper-figures")
REFERENCE = {  # end-shortenings / pi, from two solvers that are not this one
    "paper-text": (0.243045, 2.056822, 2.256610),
    "paper-figures": (0.237782, 1.918325, 2.146372),
}
TOLERANCES = (1e-7, 1e-8, 1e-9, 1e-10)
LARGEST_STEPS = (0.05, 0.1, 0.2, 0.4, 0.8)
FAST = Control(tolerance=1e-8, largest_step=0.4, turning=0.4, resolution=1.1)
REPEATS = 7


def parameters(scene: str) -> Parameters:
    """Of one of the shipped scenes."""
    return Parameters.from_scene(load_scene(HERE / f"{scene}.toml"))


def row(what: str, measured: str, wanted: str) -> None:
    """Print one line of the table."""
    print(f"{what:58s} | {measured:44s} | {wanted}", flush=True)


def warm() -> None:
    """Compile the kernels, so that what is timed is work."""
    catalogue = Catalogue(parameters("paper-text"), replace(FAST, largest_step=0.8))
    catalogue.space_path("3D", catalogue.ax(), 0)


def paths() -> None:
    """All named paths of both l = 10 scenes."""
    start, cpu = time.perf_counter(), time.process_time()
    for scene in SCENES:
        own = parameters(scene)
        branches, complaints = compute_branches(own)
        write_branches(OUT / f"branches-{scene}.h5", own, branches)
        for line in complaints:
            print(f"  {scene}: {line}")
    elapsed, cpu = time.perf_counter() - start, time.process_time() - cpu
    row("all named paths, both l = 10 scenes", f"{elapsed:.1f} s ({cpu:.1f} s CPU)", "<= 40 s")
    for scene in SCENES:
        with open_branches(OUT / f"branches-{scene}.h5") as file:
            worst = {name: np.nanmax(b.table["error"]) for name, b in file.items()}
            missing = sum(int(np.isnan(b.table["error"]).sum()) for b in file.values())
            count = sum(len(b) for b in file.values())
        text = ", ".join(f"{name} {value:.0e}" for name, value in worst.items())
        row(f"mesh-halving error, {scene}", text, "<= 1e-8 (1e-5 on Ax's upper sheets)")
        row(f"points, and those without an error estimate, {scene}", f"{count}, {missing}", "")


def ax_start(own: Parameters, control: Control) -> tuple[Tracer, Point]:
    """Ax at 0.02 pi."""
    early, start, _ = buckled(own, control, STRAIGHT_LOOP, LOOP_EVEN)
    points, _ = collect(early, start, lambda p: p.state.end_shortening > 0.02 * np.pi or None)
    tracer = Tracer(LOOP_EVEN, control, own.capillary_force)
    closing = np.stack([frozen(col.FGAMMA), frozen(col.DELTA)])
    values = np.array([own.capillary_force, 0.02 * np.pi])
    settled = settle(points[-1].state, tracer.mirror, closing, values, control.tolerance)
    return tracer, tracer.begin(settled, frozen(col.DELTA))


def timed(work: Callable[[], list[Point]]) -> tuple[float, list[Point]]:
    """Median seconds of REPEATS runs, and the last one's points."""
    seconds = []
    for _ in range(REPEATS):
        start = time.perf_counter()
        points = work()
        seconds.append(time.perf_counter() - start)
    return statistics.median(seconds), points


def tension_error(tracer: Tracer, points: list[Point]) -> float:
    """Largest mesh-halving error of the points."""
    return max(halving_error(tracer, p.state, p.tangent) for p in points)


def speed() -> None:
    """Ax from 0.02 pi to its fold, 3D from its pitchfork to L2."""
    for scene in SCENES:
        own = parameters(scene)
        tracer, start = ax_start(own, FAST)

        def to_fold(tracer: Tracer = tracer, start: Point = start) -> list[Point]:
            points, _ = collect(tracer, start, lambda p: "fold" if p.fold_function < 0.0 else None)
            points[-1] = locate(tracer, points[-2], points[-1], fold_function, "fold").point
            return points

        seconds, points = timed(to_fold)
        error = tension_error(tracer, points)
        fold = points[-1].state.end_shortening / np.pi
        text = f"{seconds:.3f} s, {len(points)} points, error {error:.0e}, fold {fold:.6f} pi"
        row(f"Ax, 0.02 pi to its fold, {scene}", text, "<= 1 s at 1e-7")
        catalogue = Catalogue(own, FAST)
        origin = catalogue.ax()
        number = origin.pitchforks[0][0]
        three: list[Tracer] = []

        def to_loop(
            catalogue: Catalogue = catalogue, number: int = number, three: list[Tracer] = three
        ) -> list[Point]:
            tracer, points = catalogue.leave(catalogue.ax(), number)[:2]
            three[:] = [tracer]
            return points

        seconds, points = timed(to_loop)
        error = tension_error(three[0], points)
        text = f"{seconds:.3f} s, {len(points)} points, error {error:.0e}"
        row(f"3D, its pitchfork to L2, {scene}", text, "<= 1 s at 1e-7")


def found(own: Parameters, control: Control) -> Iterator[float]:
    """Ax's pitchforks and fold, 3D's joint with L2, L2's next pitchfork: end-shortenings / pi."""
    catalogue = Catalogue(own, control)
    ax = catalogue.ax()
    deltas = [s.point.state.end_shortening / np.pi for _, s in ax.specials]
    kinds = [s.kind for _, s in ax.specials]
    yield from (d for d, kind in zip(deltas, kinds, strict=True) if kind == "pitchfork")
    yield next(d for d, kind in zip(deltas, kinds, strict=True) if kind == "fold")
    succession = list(catalogue.succession())
    for path in succession:
        if path.name.startswith("3D"):
            yield from (j.point.state.end_shortening / np.pi for _, _, j, _ in path.joints)


def robustness() -> None:
    """2 scenes x 4 tolerances x 5 largest steps."""
    right, most, cases = 0, 0.0, 0
    start = time.perf_counter()
    for scene in SCENES:
        own = parameters(scene)
        reference = np.array(list(found(own, Control(tolerance=1e-11, resolution=2.0))))
        for tolerance in TOLERANCES:
            for step in LARGEST_STEPS:
                cases += 1
                control = Control(tolerance=tolerance, largest_step=step)
                values = np.array(list(found(own, control)))
                same = values.shape == reference.shape
                error = float(np.abs(values - reference).max()) if same else float("inf")
                most = max(most, error)
                right += error < 1e-6
                if error >= 1e-6:
                    print(
                        f"  {scene}, tolerance {tolerance:g}, step {step:g}: off by {error:.1e} pi"
                    )
    seconds = time.perf_counter() - start
    row(
        "robustness: all pitchforks and the fold of Ax, 3D, L2",
        f"{right} of {cases}, worst {most:.0e} pi, {seconds:.0f} s",
        "40 of 40",
    )


def points() -> None:
    """Bifurcation points of both scenes."""
    for scene in SCENES:
        with open_branches(branch_file(scene)) as file:
            forks = [file["3D"].bifurcations[i]["end_shortening"] / np.pi for i in (0, -1)]
            forks.append(file["3D-L2"].bifurcations[0]["end_shortening"] / np.pi)
            tensions = [file["3D"].bifurcations[i]["end_tension"] for i in (0, -1)]
            tensions.append(file["3D-L2"].bifurcations[0]["end_tension"])
            folds = {
                name: [
                    b["end_shortening"] / np.pi
                    for b in file[name].bifurcations
                    if b["kind"] == b"fold"
                ]
                for name in ("Ax", "Pt")
            }
        wanted = REFERENCE[scene]
        worst = max(abs(a - b) for a, b in zip(forks, wanted, strict=True))
        text = ", ".join(f"{f:.7f}" for f in forks)
        row(f"bifurcation points / pi, {scene}", f"{text} (off {worst:.0e})", f"{wanted} to 1e-6")
        row(f"  their tensions, {scene}", ", ".join(f"{t:.5f}" for t in tensions), "")
        for name, values in folds.items():
            row(f"  folds of {name} / pi, {scene}", ", ".join(f"{v:.6f}" for v in values), "")


def branch_file(scene: str) -> Path:
    """The scene's branches, computed if they are not there."""
    path = OUT / f"branches-{scene}.h5"
    if not path.exists():
        own = parameters(scene)
        write_branches(path, own, compute_branches(own)[0])
    return path


def long() -> None:
    """l = 20, both end rotations, both wall strengths: the loop intervals."""
    for strength in (2e-2, 2e-4):
        for turns in (0.0, 1.0):
            own = replace(
                parameters("paper-text"),
                length=20.0,
                wall_strength=strength,
                end_rotation=2.0 * np.pi * turns,
            )
            start = time.perf_counter()
            branches, complaints = compute_branches(own, ["3D", "L"])
            seconds = time.perf_counter() - start
            what = f"l = 20, R = {2 * turns:g} pi, v0 = {strength:g}"
            text = []
            for branch in branches:
                if branch.name.startswith("L"):
                    joints = [
                        branch.points[b.index].values["end_shortening"] / np.pi
                        for b in branch.bifurcations
                        if b.partner.startswith("3D")
                    ]
                    text.append(f"{branch.name} {'-'.join(f'{d:.4f}' for d in joints)}")
            last = branches[-1]
            row(what, f"{', '.join(text)} pi; {seconds:.0f} s", "the loop intervals, <= 180 s")
            row("  ends", f"{last.name}: {last.ends} {' '.join(complaints)}", "")


def compare() -> None:
    """``derod compare`` of the default pushes, and of twice and half the edges for the rate."""
    from derod.branches.files.compare import compare as hold
    from derod.branches.files.compare import worst

    for scene in SCENES:
        errors = {}
        for edges in (150, 300, 600):
            run = OUT / f"push-{scene}-{edges}.h5"
            if not run.exists():
                command = [sys.executable, "-m", "derod", "push", str(HERE / f"{scene}.toml")]
                subprocess.run(
                    [*command, "-o", str(run), "--edges", str(edges), "--quiet"], check=True
                )
            with open_branches(branch_file(scene)) as file:
                result = hold(derod.open_run(run), file)
            off = int(np.count_nonzero(result["branch"] == ""))
            errors[edges] = {key: value for key, (value, _) in worst(result).items()}
            text = ", ".join(f"{key.split('_')[0]} {v:.1e}" for key, v in errors[edges].items())
            row(
                f"push of {scene}, {edges} edges: {len(result)} rows", text, "t, E 5e-4, shape 1e-3"
            )
            if off:
                print(f"  {off} rows lie on no branch")
        for key in ("tension_error", "energy_error", "shape_error"):
            ratios = [errors[150][key] / errors[300][key], errors[300][key] / errors[600][key]]
            text = ", ".join(f"{r:.2f}" for r in ratios)
            row(f"  {key.replace('_', ' ')} falls with twice the edges by", text, "4")


OTHERS = (
    (15.0, 8.0, 0.7, 0.05, 2e-4),
    (15.0, 12.0, 1.0, 0.2, 2e-2),
    (18.0, 9.0, 0.8, 0.05, 2e-3),
    (20.0, 12.0, 0.7, 0.2, 2e-4),
    (25.0, 8.0, 1.0, 0.1, 2e-2),
    (25.0, 11.0, 0.75, 0.07, 5e-4),
    (30.0, 10.0, 0.9, 0.05, 2e-4),
    (30.0, 12.0, 0.7, 0.2, 2e-2),
)
"""f_gamma, l, k3, rho, v0."""


def others() -> None:
    """Other parameters, nothing tuned to them."""
    for force, length, twisting, softness, strength in OTHERS:
        own = Parameters(length, twisting, force, strength, softness)
        start = time.perf_counter()
        branches, complaints = compute_branches(own, count_modes=False)
        seconds = time.perf_counter() - start
        error = max(np.nanmax([p.error for p in b.points]) for b in branches)
        what = (
            f"f_gamma {force:g}, l {length:g}, k3 {twisting:g}, rho {softness:g}, v0 {strength:g}"
        )
        names = ",".join(b.name for b in branches)
        row(what, f"{names}; error {error:.0e}; {seconds:.0f} s", "found without a guess")
        for branch in branches:
            if branch.name.startswith("3D"):
                forks = [
                    f"{branch.points[b.index].values['end_shortening'] / np.pi:.5f} ({b.partner})"
                    for b in branch.bifurcations
                    if b.partner
                ]
                print(f"    {branch.name}: {', '.join(forks)}; ends: {branch.ends}")
        for line in complaints:
            print(f"    not found: {line}")


ROWS = {f.__name__: f for f in (paths, speed, robustness, points, long, compare, others)}


def main(names: list[str]) -> int:
    """Print the rows asked for, or all."""
    unknown = [name for name in names if name not in ROWS]
    if unknown:
        print(f"no such row: {', '.join(unknown)}; rows: {', '.join(ROWS)}", file=sys.stderr)
        return 2
    OUT.mkdir(exist_ok=True)
    start = time.perf_counter()
    warm()
    row("kernels ready after", f"{time.perf_counter() - start:.1f} s", "")
    for name in names or ROWS:
        ROWS[name]()
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
