"""The README's picture: a coil in its drop and the t(delta) curve that led there.

``python viz/cover.py RUN.h5 --at 2.6 -o docs/images/coil.png --style dark``
"""

from __future__ import annotations

import argparse
import sys
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from painter import paint_shape, turned
from reading import Shape, open_files, run_shape
from shapes import coil_angle
from style import LABELS, THEMES, Theme, add_output, parsed, save, started, use

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
    paint_coil(left, run, shape, theme, coil_angle(shape) + turn)
    right = made.add_axes((0.675, 0.17, 0.305, 0.70))
    draw_curve(right, run, shape, theme)
    return made


def paint_coil(axes: Axes, run: Any, shape: Shape, theme: Theme, angle: float) -> None:
    """The coil, seen from ``angle`` about the clamps' axis."""
    paint_shape(axes, shape, turned(angle, 0.28), theme, theme.paths["3D"], 0.023, reach=0.84)
    axes.set_ylim(-0.65, 0.65)


def draw_curve(axes: Axes, run: Any, shape: Shape, theme: Theme) -> None:
    """t against delta/pi up to the state, and faintly beyond."""
    delta, t = run.table["end_shortening"] / np.pi, run.table["end_tension"]
    done = delta <= shape.end_shortening / np.pi + 1e-12
    axes.plot(delta, t, color=theme.faint, linewidth=2.0, gid="whole")
    axes.plot(delta[done], t[done], color=theme.paths["3D"], linewidth=2.4, gid="done")
    axes.plot(
        shape.end_shortening / np.pi,
        shape.end_tension,
        "o",
        markersize=9,
        color="#f2c14e",
        markeredgecolor="#6b4e00",
        gid="here",
        zorder=5,
    )
    axes.set_xlim(0, 1.04 * delta.max())
    axes.set_ylim(0, 1.12 * t.max())
    axes.set_xlabel(LABELS["delta"])
    axes.set_ylabel(LABELS["end_tension"])
    axes.set_title(
        rf"$\delta$ = {shape.end_shortening / np.pi:.2f}$\,\pi$     $t$ = {shape.end_tension:.2f}",
        fontsize=12,
        pad=8,
    )


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
