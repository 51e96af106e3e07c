"""The paper's configurations: a tube in a translucent drop, two views each, meniscus points.

``python viz/shapes.py RUN.h5 --at 0.5,2.0,2.6 -o OUT.pdf`` or, from branches,
``python viz/shapes.py BRANCHES.h5 --branch 3D:0.5 3D-L2:2.6 -o OUT.pdf`` (delta/pi).
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence

import numpy as np
from matplotlib.figure import Figure
from style import THEMES, Theme, add_output, new_figure, parsed, save, started, use

from derod.views.plots.path import family
from derod.views.plots.reading import Shape, branch_shape, open_files, run_shape
from derod.views.plots.shapes import draw_shapes


def figure(shapes: Sequence[Shape], theme: Theme, columns: int = 2) -> Figure:
    """Each shape in two views, one below the other."""
    use(theme)
    made = new_figure(1, 1)  # the drawing sets the size
    draw_shapes(made, shapes, [family(shape.name) for shape in shapes], theme, columns)
    return made


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
