"""Push rods that are hard to push, and print what became of each.

    python runs/hard_cases.py            all cases (about a minute, kernels compiled)

A case is the paper's scene with some keys changed, and the ending it must have.
"""

from __future__ import annotations

import sys
import time
from pathlib import Path
from typing import Any, NamedTuple

import derod

# isort: split
import numpy as np

from derod.frames import Outcome
from derod.record import BaseRun

HERE = Path(__file__).parent


class Case(NamedTuple):
    """Changed keys of paper-text.toml, and how the push must end."""

    changes: dict[str, Any]
    ending: Outcome = Outcome.COMPLETED


CASES = {
    "end rotation 2 pi": Case({"clamps.end_rotation": "2 pi", "push.stop": "1.5 pi"}),
    "end rotation 6 pi": Case({"clamps.end_rotation": "6 pi", "push.stop": "1.5 pi"}),
    "end rotation 12 pi": Case({"clamps.end_rotation": "12 pi", "push.stop": "0.5 pi"}),
    "wall 1e-6": Case({"drop.wall_strength": 1e-6, "push.stop": "1 pi"}),
    "wall 1e-9, softness 0.02": Case(
        {"drop.wall_strength": 1e-9, "drop.wall_softness": 0.02, "push.stop": "0.5 pi"}
    ),
    "capillary force 3": Case({"drop.capillary_force": 3, "push.stop": "0.2 pi"}),
    "capillary force 100": Case({"drop.capillary_force": 100, "push.stop": "1 pi"}),
    "capillary force 500": Case({"drop.capillary_force": 500, "push.stop": "0.5 pi"}),
    "planar, over Ax's fold": Case({"model.dimension": 2, "push.stop": "1.6 pi"}),
    "push, pull, push": Case({"push.stop": ["0.5 pi", "0.1 pi", "0.5 pi"]}),
    "start at 1 pi from nothing": Case({"push.start": "1 pi", "push.stop": "1.2 pi"}),
    "outer rod runs out": Case({"push.stop": "2.87 pi"}, Outcome.ROD_RAN_OUT),
    "length 40": Case({"rod.length": 40, "push.stop": "6 pi"}),
    "increments of 1 pi": Case({"push.max_step": "1 pi", "push.stop": "1 pi"}),
    "20 edges": Case({"mesh.edges": 20, "push.stop": "1 pi"}),
    "800 edges": Case({"mesh.edges": 800, "push.stop": "0.5 pi"}),
}


def run_case(case: Case) -> BaseRun:
    """Push a case; the run is kept in memory."""
    scene = derod.load_scene(HERE / "paper-text.toml")
    return derod.push(scene.replace({"push.at": [], **case.changes}))


def main(names: list[str]) -> int:
    """Print a line a case; return the number of those that did not end as they must."""
    failed = 0
    print(
        f"{'case':28s} {'outcome':12s} rows  delta/pi  unstable  residual  least gap      t  seconds"
    )
    for name in names or list(CASES):
        case = CASES[name]
        began = time.perf_counter()
        run = run_case(case)
        seconds = time.perf_counter() - began
        table, ending = run.table, run.ending
        outcome = ending.outcome if ending else "none"
        failed += outcome != case.ending
        events = ", ".join(event.kind for event in run.events)
        print(
            f"{name:28s} {outcome:12s} {len(run):4d}  {table['end_shortening'][-1] / np.pi:8.4f}  "
            f"{table['unstable_modes'].max():8d}  {table['residual'].max():8.1e}  "
            f"{table['wall_gap'].min():9.1e}  {table['end_tension'][-1]:8.4f}  {seconds:5.2f}  {events}",
            flush=True,
        )
    return failed


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
