"""The paper's diagrams: t and E_hat against delta/pi; stable parts solid, unstable ones dashed.

``python viz/diagram.py RUN.h5 BRANCHES.h5 -o OUT.pdf OUT.png``: any number of runs and branch
files.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from style import (
    LABELS,
    THEMES,
    Theme,
    add_output,
    new_figure,
    parsed,
    path_color,
    save,
    started,
    use,
)

from derod.views.plots.path import QUANTITIES, add_legend, draw_branch, draw_plateau
from derod.views.plots.reading import branch_shape, open_files
from derod.views.plots.specials import draw_specials

LIMITS = {"end_tension": (-2.0, 24.0), "energy_hat": (0.0, 42.0)}
MARKS = (
    ("3D", 0.5, "o", "full"), ("3D-L2", 2.6, "o", "none"),
    ("L2", 2.0, "s", "full"), ("L2", 2.1, "s", "none"),
    ("Pt", 0.6, "D", "full"), ("Pt", 1.5, "D", "none"),
    ("Tri1", 1.2, "^", "full"), ("Tri2", 1.3, "v", "none"),
)  # fmt: skip
"""States shown in the shapes figures: branch, delta/pi, the paper's kind of marker, filled or
not.
"""


def figure(
    runs: Sequence[Any],
    branches: Sequence[Any],
    theme: Theme,
    quantities: Sequence[str] = QUANTITIES,
    marks: bool = False,
) -> Figure:
    """The diagram, one panel a quantity."""
    use(theme)
    made = new_figure(6.6, 3.6 * len(quantities) + 0.2)
    panels = made.subplots(len(quantities), 1, sharex=True, squeeze=False)[:, 0]
    for axes, quantity in zip(panels, quantities, strict=True):
        panel(axes, runs, branches, theme, quantity, marks)
    panels[-1].set_xlabel(LABELS["delta"])
    add_legend(made, panels[0])
    return made


def panel(
    axes: Axes,
    runs: Sequence[Any],
    branches: Sequence[Any],
    theme: Theme,
    quantity: str,
    marks: bool = False,
) -> None:
    """One diagram: branches, their bifurcation points, run points on top, marked states."""
    for file in branches:
        for name, branch in file.items():
            draw_branch(axes, name, branch, theme, quantity)
        draw_specials(axes, file, theme, quantity)
        if marks:
            draw_marks(axes, file, theme, quantity)
    for run in runs:
        draw_run(axes, run, theme, quantity, many=bool(branches))
    if quantity == "end_tension":
        draw_plateau(axes, runs, branches, theme)
    axes.set_ylabel(LABELS[quantity])
    axes.set_ylim(*LIMITS[quantity])
    ends = [run.table["end_shortening"].max() / np.pi for run in runs]
    ends += [file["Ax"].table["end_shortening"].max() / np.pi for file in branches if "Ax" in file]
    axes.set_xlim(0, 1.04 * max(ends, default=3.0))


def draw_marks(axes: Axes, file: Any, theme: Theme, quantity: str) -> None:
    """The states that the shapes figures show, with the paper's markers."""
    for name, where, marker, fill in MARKS:
        if name not in file:
            continue
        shape = branch_shape(file[name], where * np.pi)
        axes.plot(
            shape.end_shortening / np.pi,
            getattr(shape, quantity),
            marker,
            markersize=7.5,
            color=path_color(theme, name),
            markerfacecolor=path_color(theme, name) if fill == "full" else theme.paper,
            markeredgewidth=1.4,
            gid=f"mark {name} {where}",
            zorder=8,
        )


def draw_run(axes: Axes, run: Any, theme: Theme, quantity: str, *, many: bool) -> None:
    """The increments of a push: points beside branches, a line where it is alone."""
    table = run.table
    every = max(1, len(table) // 55) if many else 1
    axes.plot(
        table["end_shortening"][::every] / np.pi,
        table[quantity][::every],
        "." if many else "-",
        markersize=5.0,
        markeredgewidth=0,
        linewidth=1.8,
        color=theme.paths["run"] if many else theme.paths["3D"],
        label="derod push" if many else f"push, $v_0$ = {run.scene.drop.wall_strength:g}",
        gid="run",
        zorder=7,
    )


def main(arguments: list[str] | None = None) -> int:
    """Draw the diagram of the files that are named."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("files", nargs="+", help="run and branch files (HDF5)")
    parser.add_argument("--quantity", choices=[*QUANTITIES, "both"], default="both")
    parser.add_argument("--marks", action="store_true", help="mark the states of shapes.py")
    add_output(parser)
    args = parsed(parser, arguments)
    files = open_files(args.files)
    quantities = QUANTITIES if args.quantity == "both" else (args.quantity,)
    made = figure(files.runs, files.branches, THEMES[args.style], quantities, args.marks)
    save(made, args.output, args.dpi, args.force)
    return 0


if __name__ == "__main__":
    sys.exit(started(main))
