"""The discrete rod with two bending stiffnesses against the branches: states, rates, jumps, and the price.

    python runs/strips.py [--only states|jumps|equal|strip]

states  K2/K1 = 2, 4, 16 at 100, 200, 400 edges: t and E_hat of the lowest states beside derod.branches
jumps   K2/K1 = 16 pushed to 0.7 pi and back to 0.1 pi: where the rod jumps, beside pitchfork and fold
equal   [1, 1] against 1, and what an angle an edge costs (K2/K1 = 1 + 1e-6): t, E_hat, CPU
strip   the paper's strip (runs/pvs-strip.toml): how long its planar coil is stable

l = 10, v0 = 2e-2, f_gamma = 20, rho = 0.1, k3 = 0.9, d_1 along e_x at both clamps.
"""

from __future__ import annotations

import argparse
import math
import tempfile
import time
from dataclasses import replace
from pathlib import Path
from typing import Any

import derod
from derod.branches.half_rod.observables import observables
from derod.branches.half_rod.parameters import Parameters
from derod.branches.paths.catalogue import Catalogue
from derod.branches.paths.path import PathNotFound
from derod.scene import build_scene
from derod.scene.plain import plain_tables

HERE = Path(__file__).parent
PI = math.pi
RATIOS = (2.0, 4.0, 16.0)
DELTAS = (0.6, 1.0, 1.5)
EDGES = (100, 200, 400)
STEP = 0.01
SHOWN = (0.25, 0.4)  # pi, of the paper's strip
PICTURE = HERE.parent / "docs/images/strip-and-round.png"


def strip(ratio: float, **changes: Any) -> derod.Scene:
    """The scene paper-figures with another section."""
    keys = {name.replace("_", ".", 1): value for name, value in changes.items()}
    section = {"rod.bending": [1.0, ratio], "clamps.directors": [0, 0]}
    return derod.load_scene(HERE / "paper-figures.toml").replace(section | keys)


def catalogue(ratio: float) -> Catalogue:
    """Ax and the space curves that leave it."""
    made = Catalogue(replace(Parameters(wall_strength=2e-2), bending_2=ratio))
    for work in (lambda: [made.ax()], made.succession, made.stiff):
        try:
            list(work())
        except PathNotFound:
            continue
    return made


def states() -> None:
    """Print relative errors of t and E_hat, and their ratios from mesh to mesh."""
    print("K2/K1  delta/pi       t (branches)    E_hat          edges: errors of t, E_hat; ratios")
    for ratio in RATIOS:
        paths = catalogue(ratio).paths.values()
        tables = {}
        for edges in EDGES:
            scene = strip(ratio, push_stop=1.5 * PI, push_at=[d * PI for d in DELTAS],
                          mesh_edges=edges)  # fmt: skip
            table = derod.push(scene).table
            tables[edges] = {round(r["end_shortening"] / PI, 6): r for r in table if r["landing"]}
        for delta in DELTAS:
            found = [observables(s) for path in paths for s in path.landings(delta * PI)]
            lowest = min(found, key=lambda values: values["energy_hat"])
            line, before = "", None
            for edges in EDGES:
                row = tables[edges][delta]
                now = [abs(row[name] / lowest[name] - 1) for name in ("end_tension", "energy_hat")]
                line += f"  {edges}: {now[0]:.1e} {now[1]:.1e}"
                if before:
                    line += f" ({before[0] / now[0]:.1f}, {before[1] / now[1]:.1f})"
                before = now
            print(f"{ratio:5g}  {delta:8g}  {lowest['end_tension']:16.8f} "
                  f"{lowest['energy_hat']:12.8f}{line}")  # fmt: skip


def jumps() -> None:
    """Print the events of the push to and fro, and the branches' places."""
    made = catalogue(16.0)
    pitchfork = made.paths["Ax"].pitchforks[0][1].point.state
    folds = [special.point.state for _, special in made.paths["3D-K2"].specials]
    fold = min(folds, key=lambda state: state.end_shortening)
    run = derod.push(
        strip(16.0, push_stop=[0.7 * PI, 0.1 * PI], push_at=[], push_max_step=STEP * PI)
    )
    print(
        f"branches: pitchfork {pitchfork.end_shortening / PI:.7f} pi, fold {fold.end_shortening / PI:.7f} pi"
    )
    for event in run.events:
        if event.kind in ("instability", "snap"):
            i = event.increment
            low, high = sorted(run.table["end_shortening"][i - 1 : i + 1] / PI)
            print(f"rod: {event.kind} between {low:.6f} and {high:.6f} pi, E_hat {event.energy_before:.6f} "
                  f"to {event.energy_after:.6f}")  # fmt: skip
    print(f"{run.outcome}; twist energy at the end {run.table['energy_twist'][-1]:.4f}")


def equal() -> None:
    """Print that [1, 1] is 1, and what frames cost where they change nothing."""
    base = derod.load_scene(HERE / "paper-figures.toml").replace({"push.stop": 2.5 * PI})
    scenes = {
        "1": base,
        "[1, 1]": base.replace({"rod.bending": [1, 1]}),
        "[1, 1 + 1e-6]": strip(1 + 1e-6, push_stop=2.5 * PI),
    }
    least = dict.fromkeys(scenes, math.inf)
    runs = {}
    for _ in range(4):
        for name, scene in scenes.items():
            clock = time.process_time()
            runs[name] = derod.push(scene)
            spent = time.process_time() - clock - runs[name].ending.compiling
            least[name] = min(least[name], spent)
    reference = runs["1"]
    for name, run in runs.items():
        same = len(run) == len(reference)
        rows = slice(None) if same else slice(-1, None)
        off = [
            abs(run.table[column][rows] - reference.table[column][rows]).max()
            for column in ("end_tension", "energy_hat")
        ]
        where = "whole push" if same else "last row"
        print(f"{name:14s} CPU {least[name]:.3f} s, {least[name] / least['1']:.2f}; "
              f"t, E_hat off by {off[0]:.1e}, {off[1]:.1e} ({where})")  # fmt: skip


def paper_strip() -> None:
    """Print where the paper's strip lies in a plane and is stable; draw it beside a round rod."""
    scene = derod.load_scene(HERE / "pvs-strip.toml").replace({"push.at": [d * PI for d in SHOWN]})
    tables = plain_tables(scene)
    del tables["material"]
    rod, drop = scene.rod, scene.require_drop()
    tables["rod"] = {"length": rod.length, "bending": rod.bending, "twisting": rod.twisting}
    tables["drop"] |= {"capillary_force": drop.capillary_force}
    tables["clamps"] = {}
    folder = Path(tempfile.mkdtemp())
    runs = [
        derod.push(scene, folder / "strip.h5"),
        derod.push(build_scene(tables), folder / "round.h5"),
    ]
    for name, run in zip(("strip", "round, the same K1 and K3"), runs, strict=True):
        print(f"{name}: {run.outcome}")
        for event in run.events:
            if event.kind != "halving":
                print(f"  {event.kind} at {event.end_shortening / PI:.4f} pi: {event.message}")
        for row in run.table[run.table["landing"]]:
            print(f"  {row['end_shortening'] / PI:.4f} pi  t = {row['end_tension']:.4f}  "
                  f"E_hat = {row['energy_hat']:.4f}  unstable {row['unstable_modes']}  "
                  f"twist {row['energy_twist']:.2g}")  # fmt: skip
    runs[0].plot("shapes", runs[1], at=[d * PI for d in SHOWN]).savefig(PICTURE)
    print(f"drawn: {PICTURE}")


def main() -> None:
    """Print the sections asked for."""
    sections = {"states": states, "jumps": jumps, "equal": equal, "strip": paper_strip}
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--only", choices=sections)
    only = parser.parse_args().only
    for name, section in sections.items():
        if only in (None, name):
            print(f"\n{name}")
            section()


if __name__ == "__main__":
    main()
