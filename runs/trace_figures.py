"""Paths of the discrete rod held against the boundary-value problem's: errors, rates, special points,
counts, CPU.

    OPENBLAS_NUM_THREADS=1 python runs/trace_figures.py [SCENE]

Ax (all sheets), 3D, L2 and Pt are traced on 100, 200 and 400 edges from the straight rod; Pt by lowering
the capillary force. Every ninth point is held against the state that ``derod branch`` solves at the same
end-shortening; folds and pitchforks against the branches' own. At 100 edges counts are held against dense
eigenvalues.
"""

from __future__ import annotations

import math
import sys
import time
import warnings
from itertools import pairwise

import numpy as np
from scipy.linalg import eigh, null_space

import derod
from derod.equilibrium.system import System
from derod.pushing.controls import CONTROLS
from derod.rod.unknowns import BORDER, F_A
from derod.scenes import read_scene
from derod.tracing.arc import Arc
from derod.tracing.path import Limits, Path, follow, joined
from derod.tracing.special import BRANCH_POINT, JOINT, between
from derod.tracing.starting import both_ways, crossing, landed
from derod.tracing.straight import buckled, bucklings
from derod.tracing.switching import switch

EDGES = (100, 200, 400)
EVERY = 9  # points
AT = 1.1 * math.pi  # D, where the force is lowered
ENERGY = 60.0


def traced(scene: derod.Scene) -> tuple[Arc, dict[str, Path], float]:
    """Return what stepped, the four paths, and the CPU seconds that they took."""
    system = System(scene)
    arc = Arc(system, CONTROLS["end_shortening"])
    straight = bucklings(system, 1)[0]
    buckled(arc, straight)  # loads the kernels
    began = time.process_time()
    limits = Limits(energy_hat=ENERGY)
    paths = {"Ax": follow(arc, buckled(arc, bucklings(system, 1)[0]), limits, "Ax")}
    first = next(one for one in paths["Ax"].specials if one.kind == BRANCH_POINT)
    paths["3D"] = follow(arc, switch(arc, first), limits, "3D")
    joint = paths["3D"].specials[-1]
    assert joint.kind == JOINT
    back, ahead = (follow(arc, switch(arc, joint, side), limits, "L2") for side in (-1.0, 1.0))
    paths["L2"] = joined(back, ahead)
    paths["Pt"] = point_symmetric(arc, limits)
    return arc, paths, time.process_time() - began


def point_symmetric(arc: Arc, limits: Limits) -> Path:
    """Return Pt: the second mode under six times the capillary force, which is then lowered."""
    system, usual = arc.system, arc.system.physics
    force = usual.capillary_force
    system.physics = usual._replace(capillary_force=6 * force)
    second = bucklings(system, 2)[1]
    way = follow(arc, buckled(arc, second), Limits(high=AT))
    system.physics = usual
    lowering = Arc(system, CONTROLS["capillary_force"])
    lowered = both_ways(
        lowering, landed(arc, way.points[-1].state, AT), Limits(low=force, high=6.1 * force)
    )
    for a, b in zip(lowered.points, lowered.points[1:], strict=False):
        if min(a.value, b.value) <= force <= max(a.value, b.value):
            guess = between(lowering, a, b, crossing(a, b, force))
            state = landed(lowering, guess, force)
    state.physics = usual
    return both_ways(arc, state, limits, "Pt")


def errors(path: Path, branch) -> tuple[float, float, int]:
    """Return the largest relative errors of t and E_hat over every ninth point, and how many there were.

    They are taken across the curve, t(delta) or E_hat(delta), in relative units: at a fold it is vertical.
    """
    delta = branch.table["end_shortening"]
    worst, count = np.zeros(2), 0
    for point in path.points[::EVERY]:
        if not delta.min() < point.value < delta.max():
            continue
        try:
            there = branch.at(point.value)
        except derod.errors.DerodError:
            continue
        here = np.array([point.here.tension, point.here.energy_hat])
        slopes = np.array([-point.here.stiffness, 0.0])
        force = point.state.physics.capillary_force
        slopes[1] = force - point.here.tension
        tilt = np.sqrt(
            1 + (point.value * slopes / [point.here.tension, point.here.energy_hat]) ** 2
        )
        off = [
            abs(here / np.array([one.values["end_tension"], one.values["energy_hat"]]) - 1) / tilt
            for one in there
        ]
        best = min(off, key=lambda pair: pair.sum())
        if best.max() > 0.02:
            continue  # beyond the stored branch: another sheet
        worst, count = np.maximum(worst, best), count + 1
    return float(worst[0]), float(worst[1]), count


def special_errors(path: Path, branch) -> list[tuple[str, float, float]]:
    """Return (kind, delta of the branch, relative error) of the branch's folds and pitchforks, if traced."""
    out = []
    for one in branch.bifurcations:
        kind, place = one["kind"].decode(), float(one["end_shortening"])
        wanted = ("fold",) if kind == "fold" else (BRANCH_POINT, JOINT)
        mine = [s for s in path.specials if s.kind in wanted]
        near = min(
            mine,
            key=lambda s: (
                abs(s.value / place - 1)
                + 0.01 * abs(s.point.here.tension / one["end_tension"] - 1)
            ),
            default=None,
        )  # fmt: skip
        if near is not None and abs(near.value / place - 1) < 5e-3:
            out.append((kind, place, abs(near.value / place - 1)))
    return out


def dense_count(arc: Arc, point) -> int:
    """Return the unstable modes by dense algebra: eigenvalues on the null space of all constraints."""
    system, state = arc.system, point.state
    system.linearise(state)
    linear, d, n = system.room.linear, system.dimension, system.edges
    band, border, corner = (np.array(one) for one in linear)
    size, m = n * system.width, corner.shape[0]
    full = np.zeros((size + m, size + m))
    for k in range(band.shape[1]):
        for j in range(size - k):
            full[j + k, j] = full[j, j + k] = band[j, k]
    full[:size, size:] = border[:size]
    full[size:, :size] = border[:size].T
    full[size:, size:] = corner
    moving = np.ones(size + m, bool)
    moving[:size].reshape(n, -1)[:, d] = False
    moving[:size].reshape(n, -1)[-1] = False
    moving[size + F_A + d :] = False
    held = np.zeros_like(moving)
    held[:size].reshape(n, -1)[:, d] = True
    held[size + F_A + d : size + BORDER + d] = True
    inner = full[np.ix_(moving, moving)]
    for helper in range(BORDER + d, m):  # condensed: twist, and the turn's deflation
        row = full[size + helper, moving]
        inner -= np.outer(row, row) / corner[helper, helper]
    basis = null_space(full[np.ix_(held, moving)])
    return int(np.count_nonzero(eigh(basis.T @ inner @ basis, eigvals_only=True) < 0))


def main() -> None:
    """Print the figures."""
    place = sys.argv[1] if len(sys.argv) > 1 else "paper-text"
    scene = read_scene(place)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        branches = derod.branch(scene, paths=["Ax", "3D", "L2", "Pt"], stability=False)
    table: dict[tuple[str, int], tuple[float, float, int]] = {}
    places: dict[tuple[str, str, float], dict[int, float]] = {}
    for edges in EDGES:
        arc, paths, seconds = traced(scene.replace({"mesh.edges": edges}))
        points = sum(len(path.points) for path in paths.values())
        print(f"{edges} edges: {points} points, {arc.evaluations} factors, {seconds:.2f} CPU s")
        for name, path in paths.items():
            table[name, edges] = errors(path, branches[name])
            for kind, at, off in special_errors(path, branches[name]):
                places.setdefault((name, kind, at), {})[edges] = off
        if edges == EDGES[0]:
            sample = [p for path in paths.values() for p in path.points[::12]]
            wrong = sum(dense_count(arc, point) != point.count for point in sample)
            print(f"  counts against dense eigenvalues: {wrong} of {len(sample)} differ")
    print("largest relative errors of t and E_hat; rates between meshes")
    for name in ("Ax", "3D", "L2", "Pt"):
        rows = [table[name, edges] for edges in EDGES]
        told = "  ".join(f"{t:.1e} {e:.1e} ({count})" for t, e, count in rows)
        rates = [f"{math.log2(a[k] / b[k]):.1f}" for k in (0, 1) for a, b in pairwise(rows)]
        print(f"  {name:3} {told}  rates t {rates[0]} {rates[1]}, E_hat {rates[2]} {rates[3]}")
    print("special points: relative error of delta, and its ratio between 200 and 400 edges")
    for (name, kind, at), by in places.items():
        told = "  ".join(f"{by.get(edges, math.nan):.1e}" for edges in EDGES)
        ratio = by.get(200, math.nan) / by.get(400, math.nan)
        print(f"  {name:3} {kind:10} {at / math.pi:.7f} pi  {told}  x{ratio:.0f}")


if __name__ == "__main__":
    main()
