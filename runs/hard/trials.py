"""Hard cases that are no plain pushes. Each returns (expected outcome, outcome, check, remark)."""

from __future__ import annotations

import os
import random
import signal
import subprocess
import sys
import tempfile
import time
from collections import Counter
from pathlib import Path
from unittest.mock import patch

import numpy as np
from hard.checks import Check
from hard.hard_wall import pt_at_a_hard_wall

import derod
from derod.equilibrium.loop import relax
from derod.equilibrium.measured import measure
from derod.equilibrium.methods import make_relaxer
from derod.equilibrium.system import System
from derod.pushing.controls import CONTROLS
from derod.pushing.driver import frame_of
from derod.pushing.encode import decode
from derod.pushing.guess import bent_guess
from derod.record import BaseRun, open_run
from derod.rod.state import State

SCENE = Path(__file__).parents[1] / "paper-text.toml"
Trial = tuple[str, str, Check, str]
TANGLES = 24
REVERSED = (0.3, 0.2, 0.1, 0.05, 0.02, 0.01)  # rad


def paper(changes: dict | None = None) -> derod.Scene:
    """Return the paper's rod with some keys changed."""
    return derod.load_scene(SCENE).replace({"push.at": [], **(changes or {})})


SHORTENING = 0.5 * np.pi


def crooked(system: System) -> State:
    """Return a nearly straight rod with its end clamp at ``SHORTENING``: every edge is too short."""
    state = bent_guess(system, system.physics, 0.02 * np.pi)
    state.q[:, 2] *= (system.physics.length - SHORTENING) / state.q[-1, 2]
    state.clamp_at(SHORTENING)
    return state


def tangle(system: System, seed: int) -> State:
    """Return a random smooth curve from clamp to clamp, turned by up to a rad or two along its way.

    Its edges have wrong lengths and its tensions are zero; it is shrunk only as far as the wall asks.
    """
    noise = np.random.default_rng(seed)
    state = crooked(system)
    s = system.arc_length(state) / system.physics.length
    shift = sum(
        np.outer(np.sin(np.pi * k * s), noise.normal(size=3)) / k ** noise.uniform(0.3, 1.0)
        for k in range(1, 13)
    )
    amplitude = noise.uniform(0.1, 1.0)
    while True:
        moved = state.copy()
        moved.q[1:-1, :3] += amplitude * shift[1:-1]
        kin = system.room.kin
        moved.b[2:5] = 0.5 * (moved.q[kin.node_a, :3] + moved.q[kin.node_b, :3])
        moved.q[1:, 3] = 0.0
        if system.wall_gap(moved) > 0.02:
            return moved
        amplitude *= 0.8


def tangled_starts() -> Trial:
    """Every tangle must end in a minimum, or say why not; none may be called settled that is not."""
    system = System(paper({"mesh.edges": 100}))
    ends: Counter[str] = Counter()
    wrong = 0
    for seed in range(TANGLES):
        solution = relax(make_relaxer("implicit"), system, tangle(system, seed), descend=True)
        ends[str(solution.outcome)] += 1
        if solution.converged:
            unstable = measure(system, solution.state, CONTROLS["end_shortening"]).unstable_modes
            system.gradient(solution.state)
            wrong += unstable != 0 or system.excess(solution.state, system.tolerance)[0] > 1
        else:
            wrong += not solution.message
    remark = ", ".join(f"{count} {name}" for name, count in ends.items())
    outcome = "minima" if ends["converged"] >= 0.75 * TANGLES else "few minima"
    return "minima", outcome, ("wrongly called settled", float(wrong), 0.0), remark


def reversed_at_the_clamp() -> Trial:
    """The first edge points back into the clamp, up to 0.01 rad from the transport's singularity.

    Explicit relaxation must take the rod back to the coil from each angle. Implicit steps may stall there,
    but what they call settled must be the coil too.
    """
    scene = paper({"mesh.edges": 100, "push.stop": SHORTENING})
    system, run = System(scene), derod.push(scene)
    coil = decode(system, frame_of(run, len(run) - 1))
    energy = run.table["energy_hat"][-1]
    ends: dict[str, Counter[str]] = {"implicit": Counter(), "fire": Counter()}
    away = 0.0
    for angle in REVERSED:
        state = coil.copy()
        edge = coil.q[1, 2]
        state.q[1, :3] = edge * np.sin(angle), 0.0, -edge * np.cos(angle)
        for method, counted in ends.items():
            solution = relax(make_relaxer(method), system, state, descend=True)
            counted[str(solution.outcome)] += 1
            if solution.converged:
                away = max(away, abs(system.energy_hat(solution.state) - energy))
    every = f"fire converged {len(REVERSED)}"
    remark = ", ".join(f"implicit {name} {count}" for name, count in ends["implicit"].items())
    outcome = ", ".join(f"fire {name} {count}" for name, count in ends["fire"].items())
    return every, outcome, ("E_hat against the coil", away, 1e-7), remark


def folded_flat() -> Trial:
    """The first edge points exactly back: no least rotation exists, and the state must be refused."""
    system = System(paper({"mesh.edges": 100}))
    state = crooked(system)
    state.q[1, :3] = 0.0, 0.0, -state.q[1, 2]
    solution = relax(make_relaxer("implicit"), system, state)
    named = float("node" not in solution.message)
    return "diverged", str(solution.outcome), ("place not named", named, 0.0), solution.message[:90]


def scaled_units() -> Trial:
    """Stiffnesses and forces times 1e-6 and 1e6: the same dimensionless answers."""
    names = ("rod.bending", "rod.twisting", "drop.capillary_force", "drop.wall_strength")
    values = (1.0, 0.9, 20.0, 2e-4)
    base = derod.push(paper({"push.stop": "0.5 pi"})).table
    worst = 0.0
    for unit in (1e-6, 1e6):
        changes = {name: unit * value for name, value in zip(names, values, strict=True)}
        table = derod.push(paper({"push.stop": "0.5 pi", **changes})).table
        if len(table) != len(base):
            return "same", "different rows", ("rows", float(len(table)), 0.0), ""
        for name in ("end_tension", "energy_hat"):
            worst = max(worst, float(np.abs(table[name] / unit / base[name] - 1).max()))
    return "same", "same", ("t, E relative", worst, 1e-9), "units of 1e-6 and 1e6"


def same_tables(a: BaseRun, b: BaseRun) -> float:
    """Return how many columns or nodes differ by a bit, the clock apart."""
    if len(a) != len(b):
        return float("inf")
    names = [name for name in a.table.dtype.names or () if name != "wall_time"]
    differing = sum(not np.array_equal(a.table[name], b.table[name]) for name in names)
    return float(differing) + float(not np.array_equal(a.positions(-1), b.positions(-1)))


def killed_twice() -> Trial:
    """kill -9 at two random moments, resumed twice: the uninterrupted table, bit for bit."""
    scene = paper({"mesh.edges": 60, "push.stop": "0.6 pi", "push.max_step": "0.002 pi"})
    whole = derod.push(scene)
    moments = random.Random(3)
    cuts = []
    with tempfile.TemporaryDirectory() as folder:
        text, path = Path(folder) / "scene.toml", Path(folder) / "run.h5"
        text.write_text(scene.text)
        command = [sys.executable, "-m", "derod", "push", str(text), "-o", str(path), "--quiet"]
        for part in (0.3, 0.6):
            process = subprocess.Popen(command)
            wanted = (part + moments.uniform(-0.1, 0.1)) * len(whole)
            while process.poll() is None and rows_in(path) < wanted:
                time.sleep(0.005)
            os.kill(process.pid, signal.SIGKILL)
            process.wait()
            cuts.append(rows_in(path))
            command = [sys.executable, "-m", "derod", "push", "--resume", str(path), "--quiet"]
        done = subprocess.run(command, check=False)
        with open_run(path) as run:
            different = same_tables(run, whole)
    check = "columns that differ", different, 0.0
    return "0", str(done.returncode), check, f"killed at rows {cuts} of {len(whole)}"


def rows_in(path: Path) -> int:
    """Return the committed rows of a file that may not be there yet."""
    if not path.exists():
        return 0
    with open_run(path) as run:
        return len(run)


class Poison:
    """An observer that puts a NaN among a kernel's numbers after some rows."""

    def __init__(self, systems: list[System], rows: int, node: int) -> None:
        self.systems, self.rows, self.node = systems, rows, node

    def start(self, scene, first_increment) -> None:
        """Nothing to do."""

    def event(self, event) -> None:
        """Nothing to do."""

    def frame(self, frame) -> None:
        """Poison the wall's quadrature at the node."""
        if frame.row["increment"] == self.rows - 1:
            self.systems[0].room.kin.share[self.node] = np.nan

    def finish(self, ending) -> None:
        """Nothing to do."""


def poisoned() -> Trial:
    """NaN in the wall's kernel at node 40 after 12 rows: caught, named, and the rows are kept."""
    systems: list[System] = []

    def remembered(scene: derod.Scene) -> System:
        systems.append(System(scene))
        return systems[0]

    rows, node = 12, 40
    with tempfile.TemporaryDirectory() as folder, patch("derod.pushing.driver.System", remembered):
        scene = paper({"mesh.edges": 100, "push.stop": "0.5 pi"})
        run = derod.push(scene, Path(folder) / "run.h5", [Poison(systems, rows, node)])
        with run:
            kept, ending = len(run), run.ending
            finite = all(np.isfinite(run.positions(i)).all() for i in range(kept))
    named = f"node {node}" in ending.message and "end-shortening" in ending.message
    wrong = float(kept != rows) + float(not finite) + float(not named)
    check = "rows lost, place not named", wrong, 0.0
    return "diverged", str(ending.outcome), check, ending.message[:110]


TRIALS = {
    "Pt, wall to 1e-9, rho to 0.005": pt_at_a_hard_wall,
    "tangled starts": tangled_starts,
    "reversed at the clamp": reversed_at_the_clamp,
    "folded flat at the clamp": folded_flat,
    "units of 1e-6 and 1e6": scaled_units,
    "kill, resume, kill, resume": killed_twice,
    "NaN in a kernel": poisoned,
}
