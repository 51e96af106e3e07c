"""The paper's diagram of the longer rod: t against delta/pi for several end rotations.

``python viz/longer.py out/l20-r0.h5 out/l20-r2pi.h5 -o OUT.pdf``. The bands are the intervals in
which the coil is planar: no twist and no holonomy but the clamps' own.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from style import LABELS, THEMES, Theme, add_output, new_figure, parsed, save, started, use

from derod.views.plots.reading import HARD_WALL, open_files, planar_intervals

LOOKS = (("3D", "-"), ("Ax", (0, (5, 2))), ("L2", (0, (1, 1.5))))


def figure(runs: Sequence[Any], theme: Theme) -> Figure:
    """One curve a run, its planar intervals as bands along the bottom."""
    use(theme)
    made = new_figure(7.6, 3.9)
    axes = made.subplots()
    for number, run in enumerate(runs):
        hue, dashes = LOOKS[number % len(LOOKS)]
        table = run.table
        rotation = run.scene.clamps.end_rotation / np.pi
        axes.plot(
            table["end_shortening"] / np.pi,
            table["end_tension"],
            color=theme.paths[hue],
            linestyle=dashes,
            linewidth=1.7,
            label=rf"$\mathcal{{R}}$ = {rotation:g}$\,\pi$" if rotation else r"$\mathcal{R}$ = 0",
            gid=f"run {number}",
        )
        for first, last in planar_intervals(run):
            axes.axvspan(
                first / np.pi,
                last / np.pi,
                0.02 + 0.04 * number,
                0.05 + 0.04 * number,
                color=theme.paths[hue],
                linewidth=0,
                gid=f"planar {number}",
            )
    force = runs[0].scene.drop.capillary_force
    axes.axhline(force - HARD_WALL, color=theme.faint, linewidth=1.0, zorder=1, gid="plateau")
    axes.set_xlim(0, max(run.table["end_shortening"].max() for run in runs) / np.pi)
    axes.set_ylim(0, 24)
    axes.set_xlabel(LABELS["delta"])
    axes.set_ylabel(LABELS["end_tension"])
    axes.set_title(rf"$\ell$ = {runs[0].scene.rod.length:g}; bars: planar coils", fontsize=11)
    axes.legend(loc="lower right", bbox_to_anchor=(1.0, 0.1), ncols=len(runs))
    return made


def main(arguments: list[str] | None = None) -> int:
    """Draw the runs that are named."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("files", nargs="+", help="run files (HDF5)")
    add_output(parser)
    args = parsed(parser, arguments)
    save(figure(open_files(args.files).runs, THEMES[args.style]), args.output, args.dpi, args.force)
    return 0


if __name__ == "__main__":
    sys.exit(started(main))
