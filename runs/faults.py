# ruff: noqa: E402 - threads are set before numpy is imported
"""Inject faults, count what comes of them, and print the table into docs/reliability.md.

    python runs/faults.py                  (all: about half an hour on two cores)
    python runs/faults.py kills signals    (some; the others keep what was measured last)
    python runs/faults.py --quick          (a tenth of the trials, the page is left alone)

What was measured is kept in runs/out/faults.json.
"""

from __future__ import annotations

import os

for name in ("OPENBLAS_NUM_THREADS", "NUMBA_NUM_THREADS", "OMP_NUM_THREADS"):
    os.environ.setdefault(name, "1")

import argparse
import json
import sys
import tempfile
import time
from importlib import import_module
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))

PAGE = ROOT / "docs" / "reliability.md"
KEPT = ROOT / "runs" / "out" / "faults.json"
BEGIN, END = "<!-- table of runs/faults.py -->", "<!-- end of the table -->"
HEAD = (
    "| tried | trials | what came of it | slowest | should not have been |\n|---|---|---|---|---|"
)
SECTIONS: dict[str, list[tuple[str, int]]] = {
    "kills": [("kills.kill_chains", 160), ("kills.copy_kills", 40), ("kills.compile_kills", 10)],
    "disks": [("kills.full_disks", 20)],
    "corruptions": [
        ("corruptions.flips_of_finished", 400),
        ("corruptions.flips_of_killed", 400),
        ("corruptions.flips_of_live", 60),
        ("corruptions.flips_of_branches", 200),
        ("corruptions.cuts", 400),
        ("corruptions.resumes", 100),
    ],
    "foreign": [("foreign.hostile_files", 84), ("foreign.noise", 100)],
    "mutations": [
        ("mutations.mutated_scenes", 1500),
        ("mutations.values", 600),
        ("mutations.pushes", 60),
    ],
    "rivals": [
        ("rivals.two_writers", 20),
        ("rivals.writer_and_resumer", 20),
        ("rivals.two_resumers", 20),
    ],
    "signals": [("signalled.signals", 60), ("signalled.storms", 20)],
    "outputs": [("printed.broken_outputs", 1), ("printed.refused_outputs", 1)],
    "cost": [("costs.interleaved", 30)],
}
"""What is tried, and how often."""


def main(arguments: list[str] | None = None) -> int:
    """Run sections, keep what they found, write the page; 1 where something was found."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("sections", nargs="*", help=f"of {', '.join(SECTIONS)} (all)")
    parser.add_argument("--quick", action="store_true", help="a tenth of the trials, no page")
    args = parser.parse_args(arguments)
    kept = json.loads(KEPT.read_text()) if KEPT.exists() else {}
    failures = 0
    for name in args.sections or SECTIONS:
        lines = []
        for place, trials in SECTIONS[name]:
            module, _, function = place.partition(".")
            run = getattr(import_module(f"tests.validation.faults.{module}"), function)
            began = time.perf_counter()
            with tempfile.TemporaryDirectory() as folder:
                found = run(Path(folder), max(trials // 10, 1) if args.quick else trials)
            lines.append(found.line())
            print(f"{found.line()}   {time.perf_counter() - began:.0f} s", flush=True)
            for failure in found.failures[:20]:
                print(f"    {failure}", flush=True)
            failures += len(found.failures)
        if not args.quick:
            kept = json.loads(KEPT.read_text()) if KEPT.exists() else {}
            kept[name] = lines
            KEPT.parent.mkdir(parents=True, exist_ok=True)
            KEPT.write_text(json.dumps(kept, indent=1))
    if not args.quick:
        write_page([line for name in SECTIONS for line in kept.get(name, [])])
    return 1 if failures else 0


def write_page(lines: list[str]) -> None:
    """Put the table into the page, between its marks."""
    text = PAGE.read_text(encoding="utf-8")
    before, _, rest = text.partition(BEGIN)
    _, _, after = rest.partition(END)
    table = "\n".join([HEAD, *lines])
    PAGE.write_text(f"{before}{BEGIN}\n{table}\n{END}{after}", encoding="utf-8")


if __name__ == "__main__":
    sys.exit(main())
