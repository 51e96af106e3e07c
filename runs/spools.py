"""Count the coils of a run where a given length of rod is in the drop, and say the forces in SI.

    derod push runs/tpu-fibre.toml -o runs/out/tpu-fibre.h5
    python runs/spools.py runs/out/tpu-fibre.h5 --wetted "2.8 mm"

Between the two increments beside that length, all is interpolated linearly. Three counts, none of them
the paper's own (it gives 4.5 by eye, from a picture where the fibre passes four times):

- loops: wetted length over pi D, the coils if every one of them were a great circle of the drop;
- winding: turns of the rod about the drop's centre, seen along the normal of the area it sweeps there;
- turning: angle by which the tangent turns inside the drop (total curvature) over 2 pi.
"""

from __future__ import annotations

import argparse
import math
import sys

import numpy as np

import derod
from derod.record.run import BaseRun
from derod.scene.units import read_measured

TAU = 2.0 * math.pi


def coils(run: BaseRun, i: int) -> dict[str, float]:
    """The three counts at increment ``i``."""
    row, nodes, arc = run.table[i], run.positions(i), run.arc_length(i)
    edges = np.diff(nodes, axis=0)
    edges /= np.linalg.norm(edges, axis=1)[:, None]
    angles = np.arccos(np.clip(np.sum(edges[1:] * edges[:-1], axis=1), -1.0, 1.0))
    wet = (arc >= row["meniscus_a"] - 1e-9) & (arc <= row["meniscus_b"] + 1e-9)
    inside = nodes[wet] - run.drop_center(i)
    normal = np.cross(inside[:-1], inside[1:]).sum(axis=0)
    across = np.linalg.svd(normal[None, :])[2][1:]  # two axes of the plane that the coil lies in
    x, y = across @ inside.T
    azimuth = np.unwrap(np.arctan2(y, x))
    return {
        "loops": float(row["wetted_length"]) / math.pi,
        "winding": float(abs(azimuth[-1] - azimuth[0])) / TAU,
        "turning": float(np.sum(angles[wet[1:-1]])) / TAU,
    }


def at_wetted_length(run: BaseRun, wetted: float) -> dict[str, float]:
    """Counts, forces (N) and end-shortening (m) where ``wetted`` metres are in the drop."""
    table = run.si.table
    after = int(np.argmax(table["wetted_length"] >= wetted))
    if after == 0:
        reach = f"{table['wetted_length'][0]:.4g} to {np.max(table['wetted_length']):.4g} m"
        raise SystemExit(f"{run.path}: the wetted length goes from {reach}")
    pair = table["wetted_length"][after - 1 : after + 1]
    share = (wetted - pair[0]) / (pair[1] - pair[0])
    sides = []
    for i in (after - 1, after):
        row = table[i]
        sides.append(
            coils(run, i)
            | {
                "end-shortening, um": row["end_shortening"] * 1e6,
                "force at the end, uN": row["end_tension"] * 1e6,
                "force at a meniscus, uN": row["force_a"] * 1e6,
                "energy E_hat, pJ": row["energy_hat"] * 1e12,
                "unstable modes": float(row["unstable_modes"]),
            }
        )
    return {name: (1.0 - share) * sides[0][name] + share * sides[1][name] for name in sides[0]}


def main() -> int:
    """Print the counts of the runs that are given."""
    parser = argparse.ArgumentParser(description="Coils and forces of runs with [material].")
    parser.add_argument("runs", nargs="+", metavar="RUN.h5")
    parser.add_argument("--wetted", default="2.8 mm", help="length of rod in the drop")
    args = parser.parse_args()
    for path in args.runs:
        with derod.open_run(path) as run:
            found = at_wetted_length(run, read_measured(args.wetted, "length").value)
        print(f"{path}, {args.wetted} in the drop")
        for name, value in found.items():
            print(f"  {name:26}{value:.5g}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
