# ruff: noqa: E402 - threads are set before numpy is imported
"""Hold the discrete rod's counts of unstable modes against those of the branches.

    python runs/unstable_modes.py                          both paper scenes, every fourth point
    python runs/unstable_modes.py --scenes paper-text --every 8 --edges 600 --verbose

Every N-th point of all named paths is put on the discrete rod's mesh, settled by plain Newton steps
(no descent, no kick) and analysed. Both sides count by the same rule for
sliding (``branches.paths.stability``, ``equilibrium.stability``) and share no code. Exit code 1
where a count differs or a state does not settle on its branch.
"""

from __future__ import annotations

import os

for variable in ("OPENBLAS_NUM_THREADS", "NUMBA_NUM_THREADS", "OMP_NUM_THREADS"):
    os.environ.setdefault(variable, "1")

import argparse
import sys
import tempfile
from pathlib import Path

import derod

# isort: split
import numpy as np

from derod.branches.files.record import open_branches
from derod.branches.files.stored import StoredBranch
from derod.branches.files.writing import write_branches
from derod.branches.half_rod.center_line import center_line
from derod.branches.half_rod.fields import evaluate_fields, interpolate
from derod.branches.half_rod.parameters import Parameters
from derod.branches.half_rod.state import HalfRod
from derod.branches.paths.compute import compute_branches
from derod.branches.paths.stability import stability
from derod.equilibrium.loop import relax
from derod.equilibrium.measured import measure
from derod.equilibrium.methods import make_relaxer
from derod.equilibrium.system import System
from derod.pushing.controls import CONTROLS
from derod.rod.state import State
from derod.scene import Scene, load_scene

HERE = Path(__file__).parent
SCENES = ("paper-text", "paper-figures")
EDGES = 600
SAME_STATE = 2e-3
"""Largest relative difference of t and E_hat between the rod's state and the branch's."""


def on_the_mesh(system: System, half: HalfRod) -> State:
    """The branch state's nodes, tensions, drop and menisci on the discrete rod's mesh."""
    prm = half.parameters
    length = prm.length
    q = np.zeros((system.edges + 1, 4))
    y_c = -float(half.nodes[-1, 1])
    force = 0.5 * float(prm.capillary_force - prm.meniscus_wall)
    y = half.nodes[half.inner]
    q_w, q_x, q_y, q_z = y[3:7]
    tangent = np.array(
        [
            2 * (q_x * q_z + q_w * q_y),
            2 * (q_y * q_z - q_w * q_x),
            q_w**2 - q_x**2 - q_y**2 + q_z**2,
        ]
    )
    force /= float(y[:3] @ tangent)
    centre = (0.0, y_c, 0.5 * (length - half.end_shortening))
    b = np.array([0.5 * length - half.sigma, 0.5 * length + half.sigma, *centre, force, force, 0.0])
    state = State(
        q,
        b,
        prm.end_rotation - length * float(half.scalars[2]),
        half.end_shortening,
        system.physics,
    )
    s = system.arc_length(state)
    q[:, :3] = center_line(half, s)
    q[1:, 3] = tensions(half, 0.5 * (s[1:] + s[:-1]))
    state.clamp_at(half.end_shortening)
    q[0, :3] = 0.0
    return state


def tensions(half: HalfRod, s: np.ndarray) -> np.ndarray:
    """n . d_3 (k,) at arc lengths ``s`` (k,) of the whole rod, K/D^2."""
    distance = np.abs(s - 0.5 * half.parameters.length)
    nodes = np.delete(half.node_arc_length, half.inner + 1)
    element = np.clip(np.searchsorted(nodes, distance, side="right") - 1, 0, half.eta.size - 1)
    at = (distance - nodes[element]) / half.lengths[element]
    y = interpolate(half, evaluate_fields(half), element, at)
    w, x, yy, z = y[:, 3:7].T
    d3 = np.stack([2 * (x * z + w * yy), 2 * (yy * z - w * x), w**2 - x**2 - yy**2 + z**2], axis=1)
    return np.asarray(np.einsum("ki,ki->k", y[:, 7:10], d3))


def hold(scene: Scene, branch: StoredBranch, every: int, verbose: bool) -> tuple[int, int, int]:
    """(states looked at, counts that differ, states that did not settle) of one branch."""
    system = System(scene)
    marked = set(branch.bifurcations["index"].tolist())
    looked = different = lost = 0
    for i in range(0, len(branch), every):
        while marked & {i - 1, i, i + 1}:  # there a mode is neutral, or too soft for either mesh
            i += 1
        if i >= len(branch):
            continue
        half = branch.solved(i)
        own = stability(half)
        looked += 1
        solution = relax(make_relaxer("implicit"), system, on_the_mesh(system, half))
        row = branch.table[i]
        where = f"{branch.name} point {i}, delta = {row['end_shortening'] / np.pi:.4f} pi"
        if not solution.converged:
            lost += 1
            print(f"  {where}: {solution.message}")
            continue
        found = measure(system, solution.state, CONTROLS["end_shortening"])
        energy = system.energy_hat(solution.state)
        apart = abs(energy - row["energy_hat"]) / max(1.0, abs(row["energy_hat"]))
        if apart > SAME_STATE:
            lost += 1
            print(
                f"  {where}: settled elsewhere, E_hat {energy:.6f} and not {row['energy_hat']:.6f}"
            )
            continue
        if verbose or found.released_modes != own.modes:
            print(
                f"  {where}: rod {found.unstable_modes} + {found.slides:d}, branch "
                f"{own.even} + {own.odd} + {own.slides:d}; sliding {found.sliding_stiffness:.3e} and "
                f"{own.sliding_stiffness:.3e}, clamp moment {found.clamp_moment:.4f} and "
                f"{own.clamp_moment:.4f}"
            )
        different += found.released_modes != own.modes
    return looked, different, lost


def main(arguments: list[str] | None = None) -> int:
    """Print one line a branch and the sum."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--scenes", default=",".join(SCENES), help="names of scenes in runs/")
    parser.add_argument("--paths", help="names separated by commas (default: all)")
    parser.add_argument("--every", type=int, default=4, help="look at every N-th point (4)")
    parser.add_argument("--edges", type=int, default=EDGES, help=f"of the discrete rod ({EDGES})")
    parser.add_argument("--branches", help="a branch file of that scene, instead of computing one")
    parser.add_argument("--verbose", action="store_true", help="print every state")
    args = parser.parse_args(arguments)
    total = np.zeros(3, dtype=int)
    with tempfile.TemporaryDirectory() as folder:
        for name in args.scenes.split(","):
            scene = load_scene(HERE / f"{name}.toml").replace({"mesh.edges": args.edges})
            path = Path(args.branches or Path(folder) / f"{name}.h5")
            if args.branches is None:
                own = Parameters.from_scene(scene)
                paths = args.paths.split(",") if args.paths else None
                write_branches(path, own, compute_branches(own, paths, count_modes=False)[0])
            with open_branches(path) as file:
                for branch in file.values():
                    if args.paths and branch.name not in args.paths.split(","):
                        continue
                    counts = hold(scene, branch, args.every, args.verbose)
                    total += counts
                    print(
                        f"{name:14s} {branch.name:6s} {counts[0]:4d} states, {counts[1]} counts "
                        f"differ, {counts[2]} not settled",
                        flush=True,
                    )
    print(
        f"{total[0]} states, {total[1]} counts differ, {total[2]} not settled (derod {derod.__version__})"
    )
    return 1 if total[1] or total[2] else 0


if __name__ == "__main__":
    sys.exit(main())
