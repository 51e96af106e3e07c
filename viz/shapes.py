"""The paper's configurations: a tube in a translucent drop, two views each, meniscus points.

``python viz/shapes.py RUN.h5 --at 0.5,2.0,2.6 -o OUT.pdf`` or, from branches,
``python viz/shapes.py BRANCHES.h5 --branch 3D:0.5 3D-L2:2.6 -o OUT.pdf`` (delta/pi).
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence

import numpy as np
from diagram import family
from matplotlib.figure import Figure
from painter import paint_shape, turned
from reading import Shape, branch_shape, open_files, run_shape
from style import THEMES, Theme, add_output, parsed, path_color, save, started, use

VIEWS = (0.35, 1.92)  # rad, the eye's turns from the coil's axis, about the clamps' axis


def figure(shapes: Sequence[Shape], theme: Theme, columns: int = 2) -> Figure:
    """Each shape in two views, one below the other."""
    use(theme)
    import matplotlib.pyplot as plt

    columns = min(columns, len(shapes))
    rows = -(-len(shapes) // columns)
    made = plt.figure(figsize=(3.5 * columns, 5.6 * rows))
    grid = made.add_gridspec(
        2 * rows, columns, left=0, right=1, bottom=0, top=1 - 0.06 / rows, hspace=0.02, wspace=0.02
    )
    for number, shape in enumerate(shapes):
        row, column = divmod(number, columns)
        facing = coil_angle(shape)
        for k, turn in enumerate(VIEWS):
            axes = made.add_subplot(grid[2 * row + k, column])
            paint_shape(
                axes, shape, turned(facing + turn), theme, path_color(theme, shape.name or "3D")
            )
            if k == 0:
                axes.set_title(title(shape), fontsize=11.5, pad=2)
    return made


def coil_angle(shape: Shape) -> float:
    """The direction about the clamps' axis in which the coil is thinnest, radians.

    Solutions may be turned about the axis at no cost; this makes their pictures comparable.
    """
    x = shape.positions - shape.drop_center
    inside = (shape.arc_length > shape.menisci[0]) & (shape.arc_length < shape.menisci[1])
    spread = np.cov(x[inside][:, :2].T)
    _, modes = np.linalg.eigh(spread)
    return float(np.arctan2(modes[1, 0], modes[0, 0]))


def title(shape: Shape) -> str:
    """Which state this is."""
    head = f"{family(shape.name)}:  " if shape.name else ""
    return (
        rf"{head}$\delta$ = {shape.end_shortening / np.pi:.3g}$\,\pi$,  "
        rf"$t$ = {shape.end_tension:.2f},  $\hat{{E}}$ = {shape.energy_hat:.2f}"
    )


def main(arguments: list[str] | None = None) -> int:
    """Draw the states that are named."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("files", nargs="+", help="run and branch files (HDF5)")
    parser.add_argument("--at", default="0.5,1.2,2.0,2.6", help="delta/pi of the run's states")
    parser.add_argument("--branch", nargs="*", default=[], metavar="NAME:X", help="states of paths")
    parser.add_argument("--columns", type=int, default=2)
    add_output(parser)
    args = parsed(parser, arguments)
    files = open_files(args.files)
    shapes = []
    for file in files.branches:
        for word in args.branch:
            name, _, where = word.partition(":")
            shapes.append(branch_shape(file[name], float(where) * np.pi))
    for run in files.runs:
        shapes += [run_shape(run, float(where) * np.pi) for where in args.at.split(",")]
    save(figure(shapes, THEMES[args.style], args.columns), args.output, args.dpi, args.force)
    return 0


if __name__ == "__main__":
    sys.exit(started(main))
