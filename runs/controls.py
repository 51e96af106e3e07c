"""Pushes by other controls, held against closed forms and against branches that share no code.

    python runs/controls.py                  # all of it, about two minutes with kernels compiled
    python runs/controls.py --only greenhill

greenhill  A clamped rod without a drop under a pull T, its end turned: the turn at which the count of
           unstable modes leaves 0, against the closed form.
tension    ``paper-figures`` under end tension: the same states as under end-shortening, and the jumps
           against the extrema and the corners of t(delta) on the branches.
weight     A heavy drop, W = 0.5, 2, 5: t, E_hat, y_C and wetted length against the branches; how the coil
           rolls and comes back.
loop       The capillary force raised at fixed end-shortening and lowered again, across a snap and not.

Exit code 1 where a figure is missed.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path
from tempfile import TemporaryDirectory

import derod

# isort: split
import numpy as np
from scipy.optimize import brentq, minimize_scalar

from derod.branches import (
    BranchFile,
    Parameters,
    compute_branches,
    heavy_states,
    open_branches,
    write_branches,
)
from derod.record import BaseRun
from derod.scene import load_scene

HERE = Path(__file__).parent
PI = np.pi


class Figures:
    """Prints figures beside what they must reach, and remembers whether one was missed."""

    def __init__(self) -> None:
        self.missed = 0

    def line(self, text: str, value: float, limit: float) -> None:
        """Print one."""
        short = not abs(value) <= limit
        self.missed += short
        print(f"  {text:64} {value:10.2e}  (<= {limit:g}){'  SHORT' * short}", flush=True)


def closed_form(tension: float) -> float:
    """The twisting moment at which a clamped rod of length 1 under a pull buckles (Greenhill), K/L."""
    if tension == 0:
        return 2 * brentq(lambda x: np.sin(x) - x * np.cos(x), 4.4, 4.6, xtol=1e-15)

    def determinant(moment: float) -> float:
        root = np.sqrt(complex(moment**2 / 4 - tension))
        waves = (moment / 2 + root, moment / 2 - root)
        rows = []
        for s in (-0.5, 0.5):
            rows.append([1, s, *(np.exp(1j * k * s) for k in waves)])
            rows.append([0, 1, *(1j * k * np.exp(1j * k * s) for k in waves)])
        value = np.linalg.det(np.array(rows)) / root**3
        return float(value.real) if abs(value.real) > abs(value.imag) else float(value.imag)

    for a, b in pairwise(np.linspace(2 * np.sqrt(tension) + 0.5, 30, 300)):
        if determinant(a) * determinant(b) < 0:
            return float(brentq(determinant, a, b, xtol=1e-13))
    raise ArithmeticError("no buckling moment")


def greenhill(figures: Figures) -> None:
    """Twist at fixed tension."""
    scene = load_scene(HERE / "greenhill.toml")
    for tension in (0.0, 1.0, 10.0, 30.0):
        exact = closed_form(tension)
        stop = 1.01 * exact / scene.rod.twisting
        run = derod.push(scene.replace({"clamps.end_tension": tension, "push.stop": stop}))
        event = next(event for event in run.events if event.kind == "instability")
        error = scene.rod.twisting * event.control_value / exact - 1
        figures.line(f"T L^2/K = {tension:g}: M L/K = {exact / PI:.6f} pi, 100 edges", error, 1e-4)


def tension(figures: Figures) -> None:
    """End tension as the control."""
    scene = load_scene(HERE / "paper-figures.toml").replace({"mesh.edges": 800, "push.at": []})
    step = {"control": "end_tension", "stop": 21.0, "at": [18.5, 19.0]}
    begun = scene.replace({"push.stop": "1.0 pi", "steps": [step]})
    up = derod.push(begun)
    down = derod.push(begun.replace({"steps": [{**step, "stop": 12.0, "at": [18.0, 17.0]}]}))
    rows = [
        row for run in (up, down) for row in run.table if row["segment"] == 1 and row["landing"]
    ]
    rows = [row for row in rows if row["end_shortening"] > 0.5 * PI]
    places = sorted(float(row["end_shortening"]) for row in rows)
    push = derod.push(scene.replace({"push.stop": "1.3 pi", "push.at": places}))
    for row in rows:
        (same,) = push.table[push.table["end_shortening"] == row["end_shortening"]]
        off = max(abs(row[n] - same[n]) / abs(same[n]) for n in ("end_tension", "energy_hat"))
        figures.line(f"t = {row['end_tension']:g}: against end-shortening", off, 1e-8)
    parameters = Parameters.from_scene(scene)
    with TemporaryDirectory() as folder:
        file = Path(folder) / "branches.h5"
        write_branches(file, parameters, compute_branches(parameters, ["Ax", "3D", "L2"])[0])
        with open_branches(file) as branches:
            jumps(figures, branches, up, down)


def jumps(figures: Figures, branches: BranchFile, up: BaseRun, down: BaseRun) -> None:
    """Where the rod jumps, against the extrema and a corner of t(delta)."""
    path, line = branches["3D"], branches["L2"]

    def t(delta: float) -> float:
        return float(path.at(delta)[0].values["end_tension"])

    for word, sign, bounds, run, kind in (
        ("maximum", -1.0, (0.7, 0.85), up, 0),
        ("minimum", 1.0, (1.1, 1.2), down, 0),
    ):
        best = minimize_scalar(
            lambda x, s=sign: s * t(x * PI),
            bounds=bounds,
            method="bounded",
            options={"xatol": 1e-7},
        )
        snaps = [event for event in run.events if event.kind == "snap"]
        figures.line(
            f"jump at the {word} of t, {sign * best.fun:.6f}",
            snaps[kind].control_value - sign * best.fun,
            1e-5,
        )
    known = line.bifurcations
    corner = known[np.argmin(np.abs(known["end_shortening"] - 2.1464 * PI))]
    last = [event for event in down.events if event.kind == "snap"][-1]
    figures.line(
        f"jump at the corner of t at L2's pitchfork, {corner['end_tension']:.6f}",
        last.control_value - float(corner["end_tension"]),
        1e-5,
    )
    print(f"  below: {down.outcome}: {down.ending.message if down.ending else ''}")


def weight(figures: Figures) -> None:
    """A heavy drop."""
    base = load_scene(HERE / "heavy.toml")
    names = {
        "end_tension": "end_tension",
        "energy_hat": "energy_hat",
        "drop_height": "drop_y",
        "wetted_length": "wetted_length",
    }
    for load in (0.5, 2.0, 5.0):
        scene = base.replace({"drop.weight": load})
        run = derod.push(scene)
        deltas = [float(row["end_shortening"]) for row in run.table if row["landing"]][1:]
        states = heavy_states(Parameters.from_scene(scene), deltas, paths=("Ax", "3D"))
        worst = 0.0
        for delta in deltas:
            (row,) = run.table[run.table["end_shortening"] == delta]
            worst = max(worst, min(
                max(abs(row[a] - state.values[b]) / max(1, abs(state.values[b])) for a, b in names.items())
                for state in states[delta] if state.stability.modes == 0
            ))  # fmt: skip
        figures.line(f"W = {load:g}: worst of t, E_hat, y_C, wetted length to 1 pi", worst, 5e-4)
        balance = run.table["end_force_y"] - run.table["start_force_y"] - load
        figures.line(f"W = {load:g}: balance of forces", float(np.abs(balance).max()), 1e-8)
    rolled = derod.push(base.replace({"push.stop": "2.4 pi", "push.at": [], "push.locate": True}))
    for event in rolled.events:
        if event.kind in ("instability", "snap"):
            print(
                f"  W = 2: {event.kind} at {event.control_value / PI:.6f} pi: {event.message[:90]}"
            )


def loop(figures: Figures) -> None:
    """The capillary force up and down."""
    base = load_scene(HERE / "paper-figures.toml")
    held = {
        "push.control": "capillary_force",
        "push.at": [],
        "push.max_step": 0.4,
        "push.start": 20.0,
    }
    for where, turns in (
        ("0.6 pi", [28.0, 20.0]),
        ("0.3 pi", [4.0, 20.0]),
        ("1.9 pi", [30.0, 4.0, 20.0]),
    ):
        run = derod.push(base.replace({**held, "clamps.end_shortening": where, "push.stop": turns}))
        report_loop(figures, where, run)


def report_loop(figures: Figures, where: str, run: BaseRun) -> None:
    """Whether a loop is closed and balanced, and what it lost in snaps."""
    table = run.table
    first, last = table[0], table[-1]
    lost = float(-table["work_defect"][table["work_defect"] < -1e-3].sum())
    events = [event for event in run.events if event.kind in ("snap", "instability")]
    off = abs(last["energy_total"] - first["energy_total"]) / abs(first["energy_total"])
    figures.line(
        f"{where}: energy where the loop ends, {len(events)} events, lost {lost:.4f}", off, 1e-6
    )
    force, wetted = table["capillary_force"], table["wetted_length"]
    work = -float(np.sum(0.5 * (wetted[1:] + wetted[:-1]) * np.diff(force)))
    if events:
        figures.line(f"{where}: work done {work:.4f} over what was lost", work / lost - 1, 2e-2)
    calm = table["smooth"]
    figures.line(
        f"{where}: work defect of smooth rows",
        float(np.abs(table["work_defect"][calm]).max()),
        1e-3,
    )
    for event in events:
        print(
            f"  {where}: {event.kind} at f_gamma = {event.control_value:.6f}: {event.message[:90]}"
        )


STUDIES: dict[str, Callable[[Figures], None]] = {
    "greenhill": greenhill,
    "tension": tension,
    "weight": weight,
    "loop": loop,
}


def main() -> int:
    """Print the figures; return 1 where one is missed."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("--only", choices=STUDIES, help="one of the studies")
    args = parser.parse_args()
    figures = Figures()
    for name, study in STUDIES.items():
        if args.only in (None, name):
            print(name, flush=True)
            study(figures)
    return 1 if figures.missed else 0


if __name__ == "__main__":
    sys.exit(main())
