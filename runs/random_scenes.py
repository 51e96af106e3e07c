# ruff: noqa: E402 - threads are set before numpy is imported
"""Push scenes drawn at random, and hold every law against their tables.

    python runs/random_scenes.py --count 500 --seed 1 --box wide
    python runs/random_scenes.py --count 200 --seed 1 --box hard --jobs 2 --markdown

Each scene is pushed at its own step and at a quarter of it; both runs are audited (runs/drawn/laws.py) and
compared at their common landings. The exit code is 1 where a fault was found.
"""

from __future__ import annotations

import os

for variable in ("OPENBLAS_NUM_THREADS", "NUMBA_NUM_THREADS", "OMP_NUM_THREADS"):
    os.environ.setdefault(variable, "1")

import argparse
import sys
import time
from collections import Counter
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path
from typing import NamedTuple

import derod

# isort: split
from drawn.boxes import BOXES, draw
from drawn.descents import Descents
from drawn.laws import audit, disagreements, side_was_open


class Result(NamedTuple):
    """What became of one scene."""

    number: int
    outcomes: tuple[str, str]  # at its step and at a quarter of it
    rows: int
    events: Counter[str]
    faults: list[str]
    apart: list[str]  # where the two pushes differ
    open_side: bool
    descending: int  # accepted steps
    uphill: int  # of these
    seconds: float
    text: str


GAVE_UP = ("not_converged", "diverged", "out_of_balance")


def push_one(box: str, seed: int, number: int) -> Result:
    """Push a scene at its step and at a quarter of it, and audit both."""
    clock = time.process_time()
    scene = draw(box, seed, number)
    changes: dict[str, object] = {"push.max_step": scene.push.max_step / 4}
    if scene.steps:
        names = ("control", "stop", "at", "max_step")
        steps = [{name: getattr(step, name) for name in names} for step in scene.steps]
        changes["steps"] = [{**step, "max_step": step["max_step"] / 4} for step in steps]
    quarter = scene.replace(changes)
    descents = [Descents(), Descents()]
    runs = [derod.push(scene, None, [descents[0]]), derod.push(quarter, None, [descents[1]])]
    faults = [
        f"{name}: {fault}"
        for name, run in zip(("step", "quarter"), runs, strict=True)
        for fault in audit(run)
    ]
    uphill = sum(one.uphill for one in descents)
    if uphill:
        faults.append(f"{uphill} descending steps went uphill")
    outcomes = tuple(str(run.ending.outcome) if run.ending else "none" for run in runs)
    return Result(
        number=number,
        outcomes=(outcomes[0], outcomes[1]),
        rows=sum(len(run) for run in runs),
        events=Counter(e.kind for run in runs for e in run.events if e.kind != "halving"),
        faults=faults,
        apart=disagreements(*runs),
        open_side=any(side_was_open(run) for run in runs),
        descending=sum(one.steps for one in descents),
        uphill=uphill,
        seconds=time.process_time() - clock,
        text=scene.text,
    )


def results(args: argparse.Namespace) -> Iterator[Result]:
    """Push all scenes, in ``--jobs`` processes."""
    numbers = args.only or range(args.count)
    if args.jobs == 1:
        yield from (push_one(args.box, args.seed, number) for number in numbers)
        return
    with ProcessPoolExecutor(args.jobs) as pool:
        futures = [pool.submit(push_one, args.box, args.seed, number) for number in numbers]
        for future in futures:
            yield future.result()


def main() -> int:
    """Print the faults and a table of what happened."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--count", type=int, default=60)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--box", choices=sorted(BOXES), default="wide")
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--only", type=int, nargs="*", help="numbers of scenes")
    parser.add_argument("--keep", type=Path, help="folder for the scenes with faults")
    parser.add_argument("--markdown", action="store_true")
    args = parser.parse_args()
    done: list[Result] = []
    for result in results(args):
        done.append(result)
        gave_up = [outcome for outcome in result.outcomes if outcome in GAVE_UP]
        troubles = [*result.faults, *gave_up, *(f"differs: {x}" for x in result.apart)]
        for trouble in troubles:
            note = " (the side was open)" if result.open_side else ""
            print(f"scene {result.number}: {trouble}{note}", flush=True)
        if troubles and args.keep:
            args.keep.mkdir(parents=True, exist_ok=True)
            (args.keep / f"{args.box}-{args.seed}-{result.number}.toml").write_text(result.text)
    report(done, args)
    return int(any(r.faults or (r.apart and not r.open_side) for r in done))


def report(done: list[Result], args: argparse.Namespace) -> None:
    """Print the table."""
    pushes = 2 * len(done)
    outcomes = Counter(outcome for r in done for outcome in r.outcomes)
    events = sum((r.events for r in done), Counter())
    lines = [
        ("scenes, each pushed twice", str(len(done))),
        ("rows", str(sum(r.rows for r in done))),
        ("silent faults", str(sum(len(r.faults) for r in done))),
        ("descending steps", str(sum(r.descending for r in done))),
        ("of these, uphill", str(sum(r.uphill for r in done))),
        ("pushes that gave up", f"{sum(outcomes[o] for o in GAVE_UP)} of {pushes}"),
        ("rod ran out", str(outcomes["rod_ran_out"])),
        ("step and quarter step differ", str(sum(bool(r.apart) for r in done))),
        ("of these, the side was open", str(sum(bool(r.apart) and r.open_side for r in done))),
        *(((f"events: {kind}"), str(count)) for kind, count in sorted(events.items())),
        ("CPU, s", f"{sum(r.seconds for r in done):.0f}"),
    ]
    if args.markdown:
        print(f"| `--box {args.box} --count {len(done)} --seed {args.seed}` | |\n|---|---|")
        print("\n".join(f"| {name} | {value} |" for name, value in lines))
    else:
        print(f"box {args.box}, seed {args.seed}")
        print("\n".join(f"  {name:32s} {value}" for name, value in lines))


if __name__ == "__main__":
    sys.exit(main())
