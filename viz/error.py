"""Error of a push along its path: each increment against the branch state at its end-shortening.

``python viz/error.py RUN.h5 [FINER.h5 ...] BRANCHES.h5 -o OUT.pdf``: one line a run.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from style import LABELS, THEMES, Theme, add_output, new_figure, parsed, save, started, use

from derod.branches.files.compare import compare
from derod.views.plots.reading import open_files

PANELS = {
    "tension_error": r"$|\Delta t|\,/\,\max(1,t)$",
    "energy_error": r"$|\Delta\hat{E}|\,/\,\max(1,\hat{E})$",
    "shape_error": r"shape, $\max|\Delta\mathbf{r}|$   ($D$)",
}
GOALS = {"tension_error": 5e-4, "energy_error": 5e-4, "shape_error": 1e-3}


def figure(compared: Sequence[tuple[str, np.ndarray]], theme: Theme) -> Figure:
    """Three panels over delta/pi; ``compared`` holds labels and results of ``compare``."""
    use(theme)
    made = new_figure(6.6, 6.4)
    panels = made.subplots(len(PANELS), 1, sharex=True)
    hues = [theme.paths[name] for name in ("3D", "Ax", "L2", "Pt")]
    for axes, (name, label) in zip(panels, PANELS.items(), strict=True):
        axes.axhline(GOALS[name], color=theme.faint, linewidth=1.0, gid="goal")
        for number, (run, rows) in enumerate(compared):
            axes.plot(
                rows["end_shortening"] / np.pi,
                np.maximum(rows[name], 1e-12),
                marker=".",
                markersize=3,
                linewidth=1.0,
                color=hues[number % len(hues)],
                label=run,
                gid="error",
            )
        axes.set_yscale("log")
        axes.set_ylabel(label)
    panels[0].set_title("error against the boundary-value branches; grey: what is asked for")
    panels[0].legend(fontsize=9.5, ncols=2, loc="best")
    panels[-1].set_xlabel(LABELS["delta"])
    panels[-1].set_xlim(left=0)
    return made


def label(run: Any) -> str:
    """Which run this is."""
    return f"{run.scene.mesh.edges} edges, {run.scene.relax.method}"


def main(arguments: list[str] | None = None) -> int:
    """Compare the runs with the branches and draw the errors."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("files", nargs="+", help="run files and a branch file (HDF5)")
    parser.add_argument("--every", type=int, default=1, help="compare every n-th increment")
    add_output(parser)
    args = parsed(parser, arguments)
    files = open_files(args.files)
    if len(files.branches) != 1 or not files.runs:
        parser.error("runs and one branch file are needed")
    compared = [(label(run), compare(run, files.branches[0], args.every)) for run in files.runs]
    save(figure(compared, THEMES[args.style]), args.output, args.dpi, args.force)
    return 0


if __name__ == "__main__":
    sys.exit(started(main))
