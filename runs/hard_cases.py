# ruff: noqa: E402 - threads are set before numpy is imported
"""Push rods that are hard to push, and print what became of each.

    python runs/hard_cases.py                  all cases (about two minutes, kernels compiled)
    python runs/hard_cases.py "10^4" kill      those with these words in their names
    python runs/hard_cases.py --markdown       as a table for docs/hard-cases.md

The pushes are listed in runs/hard/cases.toml, their checks in runs/hard/checks.py; what is not a
plain push (bad starts, units, kills, an injected NaN) is in runs/hard/trials.py. The exit code is the
number of cases that did not end as they must.
"""

from __future__ import annotations

import os

for variable in ("OPENBLAS_NUM_THREADS", "NUMBA_NUM_THREADS", "OMP_NUM_THREADS"):
    os.environ.setdefault(variable, "1")

import argparse
import sys
import time
import tomllib
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, NamedTuple

import derod

# isort: split
import numpy as np
from hard.checks import CHECKS, Check
from hard.trials import TRIALS

from derod.record import BaseRun

HERE = Path(__file__).parent


class Result(NamedTuple):
    """What became of a case."""

    name: str
    outcome: str
    residual: float  # largest, K0/D^2
    unstable: int  # modes, most
    drift: float  # of the energy against the end's work in one smooth increment, K0/D
    check: Check | None
    seconds: float
    remark: str
    good: bool


def flat(tables: dict[str, Any], prefix: str = "") -> dict[str, Any]:
    """Return nested tables as dotted keys."""
    out: dict[str, Any] = {}
    for key, value in tables.items():
        out |= flat(value, f"{prefix}{key}.") if isinstance(value, dict) else {prefix + key: value}
    return out


def scene_of(case: dict[str, Any]) -> derod.Scene:
    """Return the scene of a case; ``legs`` there and back are written out."""
    changes = {"push.at": [], **flat(case["scene"])}
    if "legs" in case:
        there, back = changes["push.stop"], changes["push.start"]
        changes["push.stop"] = [there, back] * (case["legs"] // 2)
    return derod.load_scene(HERE / "paper-text.toml").replace(changes)


def drift(run: BaseRun) -> float:
    """Return the largest error of energy against work in a smooth increment, by Hermite's rule.

    dE = -t ddelta: the trapezoid is corrected by h^2/12 times the difference of t's slopes.
    """
    table = run.table
    delta, tension = table["end_shortening"], table["end_tension"]
    calm = table["smooth"][1:] & (np.diff(delta) != 0)
    inner = np.flatnonzero(calm[:-2] & calm[1:-1] & calm[2:]) + 1
    same_way = np.sign(np.diff(delta))
    inner = inner[
        (same_way[inner - 1] == same_way[inner]) & (same_way[inner] == same_way[inner + 1])
    ]
    if not inner.size:
        return float("nan")
    slope = np.full(len(table), np.nan)
    for i in np.unique(np.concatenate([inner, inner + 1])):
        a, b = delta[i] - delta[i - 1], delta[i + 1] - delta[i]
        before = (tension[i] - tension[i - 1]) / a
        after = (tension[i + 1] - tension[i]) / b
        slope[i] = (b * before + a * after) / (a + b)
    step = delta[inner + 1] - delta[inner]
    work = 0.5 * step * (tension[inner] + tension[inner + 1])
    work += step**2 / 12 * (slope[inner] - slope[inner + 1])
    return float(np.abs(np.diff(table["energy_total"])[inner] + work).max())


def push_case(name: str, case: dict[str, Any]) -> Result:
    """Push a case of cases.toml."""
    clock = time.perf_counter()
    run = derod.push(scene_of(case))
    table, ending = run.table, run.ending
    check = CHECKS[case["check"]](run) if "check" in case else None
    unstable = int(table["unstable_modes"].max())
    good = (
        ending is not None
        and ending.outcome == case.get("ending", "completed")
        and bool(table["converged"].all())
        and unstable == case.get("unstable", 0)
        and float(table["wall_gap"].min()) > 0
        and (check is None or check[1] <= check[2])
    )
    kinds = [event.kind for event in run.events]
    events = ", ".join(
        f"{kinds.count(kind)} {kind}" for kind in dict.fromkeys(kinds) if kind != "turn"
    )
    remark = f"{len(run)} rows to {table['end_shortening'][-1] / np.pi:.4g} pi"
    return Result(
        name, ending.outcome if ending else "none", float(table["residual"].max()), unstable,
        drift(run), check, time.perf_counter() - clock, f"{remark}; {events}" if events else remark,
        good,
    )  # fmt: skip


def trial_case(name: str, trial: Callable[[], tuple[str, str, Check, str]]) -> Result:
    """Run a trial of trials.py."""
    clock = time.perf_counter()
    expected, outcome, check, remark = trial()
    good = outcome == expected and check[1] <= check[2]
    seconds = time.perf_counter() - clock
    return Result(name, outcome, np.nan, 0, np.nan, check, seconds, remark, good)


def all_cases() -> dict[str, Callable[[], Result]]:
    """Return every case by its name."""
    pushes = tomllib.loads((HERE / "hard" / "cases.toml").read_text())
    cases = {name: lambda n=name, c=case: push_case(n, c) for name, case in pushes.items()}
    return cases | {
        name: lambda n=name, t=trial: trial_case(n, t) for name, trial in TRIALS.items()
    }


def lines(result: Result, markdown: bool) -> Iterator[str]:
    """A result in a line."""
    check = "" if result.check is None else "{}: {:.1e} (<= {:.0e})".format(*result.check)
    verdict = "as it must" if result.good else "**FAILED**"
    cells = (
        result.name, result.outcome, f"{result.residual:.0e}", str(result.unstable),
        f"{result.drift:.0e}", check, f"{result.seconds:.1f}", result.remark, verdict,
    )  # fmt: skip
    if markdown:
        yield "| " + " | ".join(cells) + " |"
    else:
        yield (
            f"{cells[0]:32s} {cells[1]:13s} {cells[2]:>6s} {cells[3]:>2s} {cells[4]:>6s}  "
            f"{cells[5]:46s} {cells[6]:>5s} s  {cells[7]}  {cells[8]}"
        )


def main() -> int:
    """Print a line a case; return the number of those that did not end as they must."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("names", nargs="*", help="words of names")
    parser.add_argument("--markdown", action="store_true")
    args = parser.parse_args()
    if args.markdown:
        print(
            "| case | outcome | residual | unstable modes | energy drift | check | seconds | | verdict |"
        )
        print("|---|---|---|---|---|---|---|---|---|")
    failed = 0
    for name, case in all_cases().items():
        if args.names and not any(word in name for word in args.names):
            continue
        result = case()
        failed += not result.good
        for line in lines(result, args.markdown):
            print(line, flush=True)
    return failed


if __name__ == "__main__":
    sys.exit(main())
