"""Hold this checkout against another one: the tables of shipped scenes, and the CPU of a push, interleaved.

    git worktree add ../before aabb3c3
    python runs/before_after.py ../before

Each round pushes in a process of its own from either checkout; the least CPU of all rounds counts. Exit code
1 where a table differs by more than 1e-12 (residuals and work defects are rounding, and left out).
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parents[1]
SCENES = ("quick", "paper-text", "paper-figures")
LEFT_OUT = ("residual", "work_defect", "wall_time")
PUSH = """
import json, sys, time
sys.path.insert(0, sys.argv[1])
import derod
assert derod.__file__.startswith(sys.argv[1])
out = {}
for name in sys.argv[2:]:
    scene = derod.load_scene(f"{sys.argv[1]}/runs/{name}.toml")
    run, best = derod.push(scene), 1e9
    for _ in range(5):
        clock = time.process_time()
        derod.push(scene)
        best = min(best, time.process_time() - clock)
    table = {n: run.table[n].astype(float).tolist() for n in run.table.dtype.names}
    out[name] = [best, table]
print(json.dumps(out))
"""


def pushed(checkout: Path) -> dict[str, list]:
    """CPU seconds and tables of the scenes, from a checkout."""
    command = [sys.executable, "-P", "-c", PUSH, str(checkout), *SCENES]
    environment = os.environ | {"OPENBLAS_NUM_THREADS": "1"}
    environment.pop("NUMBA_CACHE_DIR", None)
    done = subprocess.run(
        command, capture_output=True, text=True, env=environment, cwd="/", check=True
    )
    return json.loads(done.stdout.splitlines()[-1])


def difference(old: dict[str, list], new: dict[str, list]) -> float:
    """The largest difference of common columns, relative or absolute, whichever is less."""
    worst = 0.0
    for name, values in old.items():
        if name in new and name not in LEFT_OUT:
            if len(values) != len(new[name]):
                return float("inf")
            pairs = zip(values, new[name], strict=True)
            worst = max(worst, *(abs(a - b) / (1 + abs(a)) for a, b in pairs if a == a or b == b))
    return worst


def main() -> int:
    """Print the ratios and the differences."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("other", type=Path)
    parser.add_argument("--rounds", type=int, default=3)
    args = parser.parse_args()
    least: dict[tuple[int, str], float] = {}
    tables: dict[tuple[int, str], dict[str, list]] = {}
    for _ in range(args.rounds):
        for side, checkout in enumerate((args.other.resolve(), HERE)):
            for name, (seconds, table) in pushed(checkout).items():
                least[side, name] = min(seconds, least.get((side, name), seconds))
                tables[side, name] = table
    worst = 0.0
    for name in SCENES:
        off = difference(tables[0, name], tables[1, name])
        worst = max(worst, off)
        ratio = least[1, name] / least[0, name]
        print(f"{name:15} CPU {least[0, name]:.3f} -> {least[1, name]:.3f} s, {ratio:.2f}; "
              f"tables differ by {off:.1e}")  # fmt: skip
    return int(worst > 1e-12)


if __name__ == "__main__":
    sys.exit(main())
