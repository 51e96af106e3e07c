"""Time ``derod branch`` against version 0.1 on the same machine, and hold their points together.

    python runs/branch_speed.py                    the paper's two scenes, and l = 20
    python runs/branch_speed.py --cases text,figures --repeats 3

Version 0.1 (commit 9e95062) is taken out of this repository's history into a temporary folder. The two
run in turn, each as a process of its own with one BLAS thread, after one run that compiles its
kernels; what is compared is the least CPU time (user and system, start-up included) of each. Their branch
files must have the same points (end-shortening, t, E_hat, wetted length to 1e-8) and the same counts of
unstable modes, but where the bending moment at the clamp is above SLIDING: there version 0.1 hid a
mode. Exit code 1 where points differ.
"""

from __future__ import annotations

import argparse
import os
import resource
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
from bench.old import old_sources

from derod.branches.files.record import BranchFile, open_branches
from derod.branches.files.stored import StoredBranch
from derod.branches.paths.landing import LandingError
from derod.branches.paths.stability import clamp_moment

HERE = Path(__file__).parent
CASES = {
    "text": ("paper-text.toml", None, 0.5),
    "figures": ("paper-figures.toml", None, 0.5),
    "l20": ("l20-r0.toml", "Ax,3D,L", 1.0 / 3.0),
}
"""Scene, paths, and the share of version 0.1's CPU time that is wanted."""
COLUMNS = ("end_shortening", "end_tension", "energy_hat", "wetted_length")
SAME = 1e-8
STEP = 1e-6
"""D: points further apart than this are other points of the path."""
CURVE = 5
SLIDING = 0.1
"""K0/D: at 0.12 and above sliding took part in an unstable mode on the paper's paths."""


def run(sources: Path, scene: str, paths: str | None, target: Path) -> float:
    """CPU seconds of one ``derod branch`` process that uses the package in ``sources``."""
    own = {"PYTHONPATH": str(sources), "OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}
    command = [sys.executable, "-m", "derod", "branch", str(HERE / scene), "-o", str(target)]
    if paths is not None:
        command += ["--paths", paths]
    target.unlink(missing_ok=True)  # version 0.1 knows no --force
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run([*command, "--quiet"], check=True, env={**os.environ, **own}, cwd=sources)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def apart(old: BranchFile, new: BranchFile) -> tuple[float, int, int, list[str]]:
    """(largest difference, counts changed by sliding, counts changed otherwise, remarks).

    Points are compared where both have the same; from where a step was of another length on, every
    CURVE-th point of the old branch is held against the new branch's state at its end-shortening.
    """
    worst, sliding, other, remarks = 0.0, 0, 0, []
    for name, branch in new.items():
        a, b = old[name].table, branch.table
        least = min(len(a), len(b))
        moved = np.abs(a["end_shortening"][:least] - b["end_shortening"][:least]) > STEP
        same = int(np.argmax(moved)) if moved.any() else least
        for column in COLUMNS:
            gaps = np.abs(a[column][:same] - b[column][:same])
            worst = max(worst, float((gaps / np.maximum(1.0, np.abs(a[column][:same]))).max()))
        if same < max(len(a), len(b)):
            curve = max((distance(branch, a[i]) for i in range(same, len(a), CURVE)), default=0.0)
            remarks.append(
                f"  {name}: other steps from point {same} of {len(a)} (now {len(b)}) on; the curves are "
                f"{curve:.1e} apart"
            )
            worst = max(worst, 0.5 * curve)  # both are stored to 1e-8
        for i in np.flatnonzero(a["unstable_modes"][:same] != b["unstable_modes"][:same]):
            slides = clamp_moment(branch.state(int(i))) > SLIDING
            sliding += slides
            other += not slides
            if not slides:
                remarks.append(
                    f"  {name} point {i}, delta = {b['end_shortening'][i]:.6f}: "
                    f"{a['unstable_modes'][i]} unstable modes, now {b['unstable_modes'][i]}"
                )
    return worst, sliding, other, remarks


def distance(branch: StoredBranch, row: np.void) -> float:
    """Relative distance of t and E_hat of a row from the nearest state of a branch."""
    try:
        found = branch.at(float(row["end_shortening"]))
    except LandingError:
        return float("inf")
    return min(
        max(
            abs(landing.values[key] - row[key]) / max(1.0, abs(row[key]))
            for key in ("end_tension", "energy_hat")
        )
        for landing in found
    )


def main(arguments: list[str] | None = None) -> int:
    """Print one line a case, and the sum of the paper's two scenes."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--cases", default=",".join(CASES), help=f"of {', '.join(CASES)}")
    parser.add_argument("--repeats", type=int, default=2, help="runs of each, in turn (2)")
    args = parser.parse_args(arguments)
    total, good = {"old": 0.0, "new": 0.0}, True
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "old").mkdir()
        sources = {"old": old_sources(folder / "old"), "new": HERE.parent}
        for which, path in sources.items():  # compile
            run(path, "paper-figures.toml", "Ax,3D", folder / f"{which}.h5")
        for case in args.cases.split(","):
            scene, paths, wanted = CASES[case]
            least = {"old": float("inf"), "new": float("inf")}
            for _ in range(args.repeats):
                for which, path in sources.items():
                    seconds = run(path, scene, paths, folder / f"{which}.h5")
                    least[which] = min(least[which], seconds)
            with (
                open_branches(folder / "old.h5") as old,
                open_branches(folder / "new.h5") as new,
            ):
                points = sum(map(len, new.values()))
                worst, sliding, other, remarks = apart(old, new)
            good &= worst <= SAME
            for line in remarks:
                print(line)
            print(
                f"{case:8s} {points} points: {least['old']:.1f} s, now {least['new']:.1f} s: "
                f"{least['new'] / least['old']:.3f} (wanted {wanted:.2f}); points apart {worst:.1e}, "
                f"counts changed {sliding} by sliding, {other} otherwise",
                flush=True,
            )
            if case in ("text", "figures"):
                for which, seconds in least.items():
                    total[which] += seconds
    if total["old"]:
        print(f"l = 10 in sum: {total['new'] / total['old']:.3f} (wanted 0.50)")
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main())
