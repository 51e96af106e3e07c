"""The README's picture: a coil in its drop and the t(delta) curve that led there.

``python viz/cover.py RUN.h5 --at 2.6 -o docs/images/coil.png --style dark``
"""

from __future__ import annotations

import argparse
import sys
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from style import THEMES, Theme, add_output, parsed, save, started, use

from derod.views.plots.movie import draw_curve, paint_coil
from derod.views.plots.reading import open_files, run_shape
from derod.views.plots.shapes import coil_angle

STEEP = 1.15  # rad, the eye's turn from the coil's axis


def figure(
    run: Any, at: float, theme: Theme, *, turn: float = STEEP, size: tuple[float, float] = (10, 4.6)
) -> Figure:
    """The state nearest to ``at`` (D), turned by ``turn`` from the coil's axis, and the curve."""
    use(theme)
    import matplotlib.pyplot as plt

    made = plt.figure(figsize=size)
    left = made.add_axes((0.0, 0.0, 0.6, 1.0))
    shape = run_shape(run, at)
    paint_coil(left, shape, theme, coil_angle(shape) + turn)
    right = made.add_axes((0.675, 0.17, 0.305, 0.70))
    draw_curve(right, run, int(np.argmin(abs(run.table["end_shortening"] - at))), theme)
    return made


def main(arguments: list[str] | None = None) -> int:
    """Draw the picture of a run."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("file", help="run file (HDF5)")
    parser.add_argument("--at", type=float, default=2.6, help="delta/pi")
    parser.add_argument("--turn", type=float, default=STEEP, help="of the eye, rad")
    add_output(parser)
    args = parsed(parser, arguments)
    run = open_files([args.file]).runs[0]
    made = figure(run, args.at * np.pi, THEMES[args.style], turn=args.turn)
    save(made, args.output, args.dpi, args.force)
    return 0


if __name__ == "__main__":
    sys.exit(started(main))
