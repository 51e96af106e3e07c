# ruff: noqa: E402 - threads are set before numpy is imported
"""Land on space paths beside their joints with planar ones, on random scenes, and judge the landings.

    python runs/landings.py --count 20 --seed 1

For every joint of 3D, 3D-L2, ... the interval beside it and the next one are landed in, at SHARES of
their end-shortening, once as ``branch.at`` gives it. The judge is another continuation: from the
interval's far end, on elements half as long, by arclength along the path's own tangents in steps of
a fifth of the interval up to where the space path crosses the plane; its state at the same
end-shortening is found by Brent's method in arclength. Where that walk fails, a second judge is the landing's
own state on elements cut in two. Wrong: no out-of-plane content, or t or E_hat off by
more than 1e-7 (relative, or to one). Exit code 1 where a landing is wrong or missing.
"""

from __future__ import annotations

import os

for variable in ("OPENBLAS_NUM_THREADS", "NUMBA_NUM_THREADS", "OMP_NUM_THREADS"):
    os.environ.setdefault(variable, "1")

import argparse
import sys
import tempfile
import time
from dataclasses import dataclass, replace
from pathlib import Path

import derod

# isort: split
import itertools

import numpy as np

from derod.branches.files.record import open_branches
from derod.branches.files.stored import StoredBranch
from derod.branches.files.writing import write_branches
from derod.branches.half_rod import closure as col
from derod.branches.half_rod.mesh import RESOLUTION, adapted, halved
from derod.branches.half_rod.mirror import FULL
from derod.branches.half_rod.observables import observables
from derod.branches.half_rod.outcome import NotConverged
from derod.branches.half_rod.parameters import Parameters
from derod.branches.half_rod.state import HalfRod
from derod.branches.half_rod.symmetry import plane
from derod.branches.paths.arc import Control, Point, Tracer, frozen
from derod.branches.paths.compute import compute_branches
from derod.branches.paths.joints import crossed_plane
from derod.branches.paths.landing import LandingError
from derod.branches.paths.newton import settle
from derod.branches.paths.special import locate
from derod.scene import load_scene

HERE = Path(__file__).parent
SHARES = (0.0, 1e-3, 0.05, 0.3, 0.5, 0.7, 0.95)
"""Of the interval's end-shortening, from the joint on."""
FINER = 2.0
LIMIT = 1e-7
RESOLVED = 5e-8
"""Nearest to a joint (D): where it lies changes by up to 6e-9 from mesh to mesh."""
FLAT = 0.5
"""Least out-of-plane content, as a share of the judge's."""


@dataclass
class Tally:
    """What came of the landings of one scene, or of all."""

    tried: int = 0
    wrong: int = 0
    missing: int = 0
    halved: int = 0
    worst: float = 0.0
    estimate: float = 0.0

    def add(self, other: Tally) -> None:
        """Add another scene's."""
        self.tried += other.tried
        self.wrong += other.wrong
        self.missing += other.missing
        self.halved += other.halved
        self.worst = max(self.worst, other.worst)
        self.estimate = max(self.estimate, other.estimate)


def random_parameters(rng: np.random.Generator) -> Parameters:
    """A rod and a drop drawn from a wide box around the paper's."""
    return Parameters(
        length=float(rng.uniform(8.0, 11.0)),
        twisting=float(rng.uniform(0.7, 1.0)),
        capillary_force=float(rng.uniform(16.0, 28.0)),
        wall_strength=float(10.0 ** rng.uniform(-4.0, -1.7)),
        wall_softness=float(rng.uniform(0.06, 0.16)),
    )


def judge(branch: StoredBranch, far: int, joint: int, deltas: list[float]) -> list[Point | None]:
    """The judge's states at end-shortenings between a point and the joint beside (or near) it."""
    control = Control(tolerance=1e-11)
    state = adapted(branch.solved(far), FINER * RESOLUTION)
    force = float(state.scalars[col.FGAMMA - col.CX])
    tracer = Tracer(FULL, control, force)
    odd = plane(branch.state(joint))[1].kept  # type: ignore[index]
    inward = np.zeros(col.KEPT)
    inward[odd] = -state.kept[odd]
    closing = np.stack([frozen(col.FGAMMA), tracer.metric * inward])
    settled = settle(state, FULL, closing, closing @ state.kept, control.tolerance, 16)
    points = [tracer.begin(settled, inward)]
    length = 0.2 * float(np.sqrt(tracer.metric @ inward**2))
    while len(points) < 200:
        try:
            points.append(tracer.advance(points[-1], length, remesh=False))
        except NotConverged:
            length *= 0.5
            if length < 1e-6:
                break
            continue
        if crossed_plane(points[-2].state, points[-1].state):
            break
    out: list[Point | None] = []
    for delta in deltas:
        found = None
        for a, b in itertools.pairwise(points):
            ends = (a.state.end_shortening - delta, b.state.end_shortening - delta)
            last = b is points[-1]
            if ends[0] * ends[1] <= 0.0 or (last and abs(ends[1]) < abs(ends[0]) * 1e3):
                found = _between(tracer, a, b, delta, odd)
                break
        out.append(found)
    return out


def _between(tracer: Tracer, a: Point, b: Point, delta: float, odd: np.ndarray) -> Point | None:
    """The state at ``delta`` between two points, on a's side of the plane."""

    def off(point: Point) -> float:
        return point.state.end_shortening - delta

    right = b
    for _ in range(60):  # beyond the plane the path comes back: cut until this side alone is left
        same = right.state.kept[odd] @ a.state.kept[odd] > 0.0
        if off(a) * off(right) < 0.0 and same:
            try:
                return locate(tracer, a, right, off, "landing").point
            except NotConverged:  # too long a step beside the joint: cut on
                pass
        middle = tracer.advance(a, 0.5 * (right.arc - a.arc), remesh=False)
        if off(a) * off(middle) > 0.0 and middle.state.kept[odd] @ a.state.kept[odd] > 0.0:
            a = middle
        else:
            right = middle
    return None


def by_halves(state: HalfRod) -> HalfRod:
    """The second judge: the landing's state at its end-shortening with every element cut in two.

    Its out-of-plane content is held against the square-root law from the joint to its neighbour.
    """
    closing = np.stack([frozen(col.FGAMMA), frozen(col.DELTA)])
    return settle(halved(state), FULL, closing, closing @ state.kept, 1e-11, 16).state


def joints(branch: StoredBranch) -> list[tuple[int, int]]:
    """(joint's row, step toward the path's inside) of a space path."""
    last = len(branch) - 1
    at = set(branch.bifurcations["index"].tolist())
    pairs = [(row, step) for row, step in ((0, 1), (last, -1)) if row in at]
    return [(row, step) for row, step in pairs if plane(branch.state(row)) is not None]


def try_joint(branch: StoredBranch, row: int, step: int, verbose: bool) -> Tally:
    """Land in the two intervals beside a joint."""
    out = Tally()
    d = branch.table["end_shortening"]
    for near, far in ((row, row + step), (row + step, row + 2 * step)):
        span = float(d[far] - d[near])
        least = RESOLVED if near == row else 1e-10
        deltas = [
            float(d[near] + np.copysign(max(share * abs(span), least), span))
            for share in SHARES
            if share * abs(span) < abs(span) - least
        ]
        for delta, reference in zip(deltas, judge(branch, far, row, deltas), strict=True):
            out.tried += 1
            where = f"{branch.name}, {min(near, far)}, delta = {delta / np.pi:.9f} pi"
            try:
                found = [one for one in branch.at(delta) if one.interval == min(near, far)]
            except LandingError as error:
                out.missing += 1
                print(f"  {where}: {error}")
                continue
            if len(found) != 1:
                out.missing += 1
                print(f"  {where}: {len(found)} states")
                continue
            landing = found[0]
            odd = plane(branch.state(row))[1].kept  # type: ignore[index]
            content = np.linalg.norm(landing.state.kept[odd])
            if reference is None:
                out.halved += 1
                judged = by_halves(landing.state)
                share = abs((delta - d[row]) / (d[row + step] - d[row]))
                content /= np.sqrt(share) * np.linalg.norm(branch.state(row + step).kept[odd])
            else:
                judged = reference.state
                content /= np.linalg.norm(judged.kept[odd])
            wanted = observables(judged)
            error = max(
                abs(landing.values[name] - wanted[name]) / max(1.0, abs(wanted[name]))
                for name in ("end_tension", "energy_hat")
            )
            out.worst = max(out.worst, error)
            out.estimate = max(out.estimate, landing.tension_error, landing.energy_error)
            wrong = content < FLAT or error > LIMIT
            out.wrong += wrong
            if wrong or verbose:
                print(f"  {where}: error {error:.1e}, out-of-plane content {content:.6f}")
    return out


def try_scene(own: Parameters, folder: Path, verbose: bool) -> Tally:
    """Trace the space paths of one scene and land beside all of their joints."""
    out = Tally()
    branches, complaints = compute_branches(own, ["3D"], count_modes=False)
    for line in complaints:
        print(f"  {line}")
    path = folder / "b.h5"
    write_branches(path, own, branches)
    with open_branches(path) as file:
        for branch in file.values():
            if len(branch) < 4:
                continue
            for row, step in joints(branch):
                out.add(try_joint(branch, row, step, verbose))
    return out


def main(arguments: list[str] | None = None) -> int:
    """Print one line a scene and the sum."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--count", type=int, default=20, help="random scenes (20)")
    parser.add_argument("--seed", type=int, default=1, help="of the random scenes (1)")
    parser.add_argument("--scene", help="this scene file instead of random ones")
    parser.add_argument("--verbose", action="store_true", help="print every landing")
    args = parser.parse_args(arguments)
    rng = np.random.default_rng(args.seed)
    scenes = [random_parameters(rng) for _ in range(args.count)]
    if args.scene:
        scenes = [replace(Parameters.from_scene(load_scene(args.scene)), bending=1.0)]
    total = Tally()
    with tempfile.TemporaryDirectory() as folder:
        for own in scenes:
            start = time.perf_counter()
            tally = try_scene(own, Path(folder), args.verbose)
            total.add(tally)
            print(
                f"l {own.length:.3f} k3 {own.twisting:.3f} f {own.capillary_force:.3f} v0 "
                f"{own.wall_strength:.2e} rho {own.wall_softness:.3f}: {tally.tried} landings, "
                f"{tally.wrong} wrong, {tally.missing} missing, worst {tally.worst:.1e}, "
                f"{time.perf_counter() - start:.0f} s",
                flush=True,
            )
    print(
        f"{len(scenes)} scenes, {total.tried} landings beside joints: {total.wrong} wrong, "
        f"{total.missing} missing, {total.halved} judged by halves, "
        f"worst error of t and E_hat {total.worst:.1e}, worst estimate "
        f"{total.estimate:.1e} (derod {derod.__version__})"
    )
    return 1 if total.wrong or total.missing or not total.tried else 0


if __name__ == "__main__":
    sys.exit(main())
