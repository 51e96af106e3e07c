"""States of the paper's rod with a heavy drop, from the boundary-value problem, as a table.

    python runs/heavy_branches.py [--weights 0.5 2 5] [--deltas 0.05 0.1 0.25 0.5 0.75 1.0] [--csv FILE]

The rod of runs/paper-figures.toml (l = 10, f_gamma = 20, v0 = 2e-2), W in K0/D^2, end-shortenings in units
of pi D. For each: the hanging planar states, stable or not, and the states without an unstable mode;
with --all every state found. even, odd: unstable flip-even and flip-odd modes (rolling is among these); k:
stiffness of sliding the drop along the rod (K0/D^3), an unstable mode more where it says "slides".
"""

from __future__ import annotations

import argparse
import csv
from pathlib import Path

import numpy as np

from derod.branches import HeavyState, Parameters, heavy_states
from derod.scene import load_scene

SCENE = Path(__file__).parent / "paper-figures.toml"
COLUMNS = ("end_tension", "energy_hat", "drop_y", "wetted_length")


def shown(states: list[HeavyState], everything: bool) -> list[HeavyState]:
    """What the table shows of the states at one end-shortening."""
    return [
        one
        for one in states
        if everything or (one.planar and one.origin == "Ax") or one.stability.modes == 0
    ]


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--weights", type=float, nargs="+", default=[0.5, 2.0, 5.0])
    parser.add_argument(
        "--deltas", type=float, nargs="+", default=[0.05, 0.1, 0.25, 0.5, 0.75, 1.0]
    )
    parser.add_argument("--all", action="store_true", help="every state found")
    parser.add_argument("--csv", type=Path, help="write the rows to this file too")
    args = parser.parse_args()
    light = Parameters.from_scene(load_scene(SCENE))
    rows = []
    print(
        "   W  delta/pi  state           t          E_hat        y_C        wetted  even odd      k"
    )
    for weight in args.weights:
        deltas = [x * np.pi for x in args.deltas]
        for delta, states in heavy_states(light.with_weight(weight), deltas).items():
            for one in shown(states, args.all):
                found = one.stability
                kind = "planar" if one.planar else "space"
                numbers = [one.values[name] for name in COLUMNS]
                modes = [found.even, found.odd, found.sliding_stiffness]
                print(
                    f"{weight:4.1f}  {delta / np.pi:8.4f}  {one.origin:8s} {kind:6s}"
                    + "".join(f"{x:12.7f}" for x in numbers)
                    + f"{found.even:4d} {found.odd:4d} {found.sliding_stiffness:9.4f}"
                    + ("  slides" if found.slides else "")
                )
                rows.append([weight, delta, one.origin, kind, *numbers, *modes, found.slides])
    if args.csv:
        with args.csv.open("w", newline="") as file:
            table = csv.writer(file)
            table.writerow(
                [
                    "W",
                    "delta",
                    "origin",
                    "kind",
                    *COLUMNS,
                    "even",
                    "odd",
                    "sliding_stiffness",
                    "slides",
                ]
            )
            table.writerows(rows)


if __name__ == "__main__":
    main()
