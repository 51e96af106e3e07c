"""Remake every figure of the paper from nothing: ``python viz/paper.py -o viz/out [--images
docs/images]``.

Runs the pushes and branches that are missing in the output folder (``data/``), two at a time, then
draws: both l = 10 diagrams for both wall strengths, the four configuration figures, the l = 20
diagram with both end rotations, and the figures that the paper has not (errors, energies,
kymograph). The last step is a table of our values beside the paper's.
"""

from __future__ import annotations

import argparse
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import diagram
import energies
import error
import kymograph
import longer
import numpy as np
import shapes
from stated import stated_table
from style import THEMES, save
from tqdm import tqdm

import derod
from derod.branches.files.compare import compare
from derod.cli import carry_out
from derod.files.outputs import replacing
from derod.pushing.frames import Outcome
from derod.terminal import say
from derod.views.plots.reading import branch_shape
from derod.views.stream.replay import is_branch_file

ROOT = Path(__file__).resolve().parent.parent
SCENES = ("text", "figures")
CONFIGURATIONS = {
    "shapes-3d": [("3D", 0.5), ("3D-L2", 2.6)],  # circles, full and empty
    "shapes-l2": [("L2", 2.0), ("L2", 2.1)],  # squares
    "shapes-pt": [("Pt", 0.6), ("Pt", 1.5)],  # diamonds
    "shapes-triangles": [("Tri1", 1.2), ("Tri2", 1.3)],
}


def jobs(data: Path) -> dict[Path, list[str]]:
    """What must be computed: files and the derod commands that make them.

    The first two compile different kernels, side by side; the others find them compiled.
    """
    scenes = ROOT / "runs"
    text, figures = str(scenes / "paper-text.toml"), str(scenes / "paper-figures.toml")
    return {
        data / "text-branches.h5": ["branch", text],
        data / "l20-r0.h5": ["push", str(scenes / "l20-r0.toml"), "--quiet"],
        data / "l20-r2pi.h5": ["push", str(scenes / "l20-r2pi.toml"), "--quiet"],
        data / "text.h5": ["push", text, "--quiet"],
        data / "figures.h5": ["push", figures, "--quiet"],
        data / "text-fine.h5": ["push", text, "--quiet", "--edges", "400"],
        data / "figures-branches.h5": ["branch", figures],
    }


def compute(data: Path, workers: int) -> list[str]:
    """Make the files that are missing, go on with those that were interrupted; returns complaints.

    A push that ends early by itself keeps its file: it would end there again.
    """
    data.mkdir(parents=True, exist_ok=True)
    todo = {path: words for path, words in jobs(data).items() if state_of(path) != FINISHED}

    def run(item: tuple[Path, list[str]]) -> str | None:
        path, words = item
        done = subprocess.run(
            [sys.executable, "-m", "derod", *command(path, words)],
            cwd=ROOT,
            capture_output=True,
            text=True,
            check=False,
        )
        if done.returncode == 0:
            return None
        return f"derod {' '.join(words[:2])}: exit code {done.returncode}: {done.stderr.strip()}"

    with ThreadPoolExecutor(workers) as pool:
        results = pool.map(run, todo.items())
        return [text for text in tqdm(results, "computing", len(todo)) if text is not None]


FINISHED, INTERRUPTED, MISSING = "finished", "interrupted", "missing"


def state_of(path: Path) -> str:
    """Whether a run or branch file is finished, was interrupted, or is missing or useless.

    It is what the file says that counts, not that it is there.
    """
    if not path.exists():
        return MISSING
    try:
        if is_branch_file(str(path)):
            with derod.open_branches(path) as file:
                return FINISHED if file.complete else INTERRUPTED
        with derod.open_run(path, verify=True) as run:
            cut = (None, Outcome.INTERRUPTED, Outcome.RECORD_FAILED)
            return INTERRUPTED if run.outcome in cut else FINISHED
    except derod.RecordError:
        return MISSING


def command(path: Path, words: list[str]) -> list[str]:
    """The derod command that makes ``path``, or goes on with it."""
    quiet = ["--quiet"] if "--quiet" in words else []
    if state_of(path) == INTERRUPTED:
        return [words[0], "--resume", str(path), *quiet]
    return [*words, "-o", str(path), "--force"]


def draw(
    data: Path, out: Path, style: str, endings: tuple[str, ...], dpi: int, force: bool
) -> None:
    """Draw all figures."""
    theme = THEMES[style]

    def keep(figure: Any, name: str) -> None:
        save(figure, [out / f"{name}.{ending}" for ending in endings], dpi, force)

    runs = {name: derod.open_run(data / f"{name}.h5") for name in SCENES}
    files = {name: derod.open_branches(data / f"{name}-branches.h5") for name in SCENES}
    for name in SCENES:
        keep(diagram.figure([runs[name]], [files[name]], theme, marks=True), f"diagram-{name}")
    for name, states in CONFIGURATIONS.items():
        drawn = [
            branch_shape(files["figures"][path], where * np.pi)
            for path, where in states
            if path in files["figures"]
        ]
        keep(shapes.figure(drawn, theme), name)
    long_runs = [derod.open_run(data / f"{name}.h5") for name in ("l20-r0", "l20-r2pi")]
    keep(longer.figure(long_runs, theme), "diagram-l20")
    fine = derod.open_run(data / "text-fine.h5")
    compared = [
        (error.label(run), compare(run, files["text"], every=3)) for run in (runs["text"], fine)
    ]
    keep(error.figure(compared, theme), "error-text")
    keep(energies.figure(runs["text"], theme), "energies-text")
    keep(kymograph.figure(runs["text"], theme), "kymograph-text")
    table = stated_table(runs, files)
    with replacing(data.parent / "stated.md", force=force) as passing:
        passing.write_text(table, encoding="utf-8")
    print(table)


def main(arguments: list[str] | None = None) -> int:
    """Compute and draw."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("-o", "--output", default="viz/out", help="folder for data and figures")
    parser.add_argument("--images", help="folder for PNGs only, e.g. docs/images")
    parser.add_argument("--style", choices=sorted(THEMES), default="light")
    parser.add_argument("--force", action="store_true", help="replace figures that exist")
    parser.add_argument("--workers", type=int, default=2, help="pushes and branches at a time")
    args = parser.parse_args(arguments)
    began = time.perf_counter()
    out = Path(args.output)
    complaints = compute(out / "data", args.workers)
    for line in complaints:
        say(f"paper.py: {line}")
    cut = [path for path in jobs(out / "data") if state_of(path) != FINISHED]
    if cut:
        say(f"paper.py: nothing is drawn: not finished: {', '.join(path.name for path in cut)}")
        return 3
    if args.images:
        draw(out / "data", Path(args.images), args.style, ("png",), 110, args.force)
    else:
        draw(out / "data", out, args.style, ("pdf", "png"), 160, args.force)
    print(f"{time.perf_counter() - began:.0f} s")
    return 3 if complaints else 0


if __name__ == "__main__":
    sys.exit(carry_out(main))
