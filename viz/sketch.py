"""The set-up with its names: clamps, menisci A and B, end-shortening, end rotation, the drop.

``python viz/sketch.py -o docs/images/sketch.png`` pushes a short rod itself.
"""

from __future__ import annotations

import argparse
import sys
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import FancyArrowPatch
from style import THEMES, Theme, add_output, new_figure, parsed, save, started, use

import derod
from derod.views.plots.painter import View, paint_shape
from derod.views.plots.reading import Shape, run_shape_at
from derod.views.plots.shapes import coil_angle

RADIUS = 0.03  # D, of the tube
MARGIN = 1.0  # D, beyond the clamps
CHANGES = {"rod.length": 4.0, "push.stop": "0.2 pi", "push.at": [], "mesh.edges": 100}
UP, DOWN = 0.82, -1.02  # D, what is shown above and below


def figure(run: Any, theme: Theme) -> Figure:
    """The last state, named."""
    use(theme)
    made = new_figure(10, 3.7)
    made.set_layout_engine("none")
    axes = made.add_axes((0, 0, 1, 1))
    shape = run_shape_at(run, len(run) - 1)
    eye = side_view(shape)
    reach = 0.5 * float(np.ptp(shape.positions[:, 2])) + MARGIN
    paint_shape(axes, shape, eye, theme, theme.paths["3D"], RADIUS, reach)
    axes.set_xlim(-reach, reach)
    axes.set_ylim(DOWN, UP)
    name_parts(axes, shape, eye, theme, run.scene.rod.length)
    return made


def side_view(shape: Shape) -> View:
    """The eye that sees the coil's plane face on, the clamps' axis to the right and the coil up."""
    angle = coil_angle(shape)
    thin = np.array([np.cos(angle), np.sin(angle), 0.0])
    up = np.cross(thin, [0.0, 0.0, 1.0])
    coil = shape.positions[len(shape.positions) // 2] - shape.positions[0]
    if up @ coil < 0:
        thin, up = -thin, -up
    return View(np.stack([np.array([0.0, 0.0, 1.0]), up, np.cross([0.0, 0.0, 1.0], up)]))


def name_parts(axes: Axes, shape: Shape, eye: View, theme: Theme, length: float) -> None:
    """Words and arrows, each beside what it names."""
    start, end = (eye.see(shape.positions[i] - shape.center)[:2] for i in (0, -1))
    a, b = (
        eye.see(np.array([np.interp(s, shape.arc_length, x) for x in shape.positions.T]) - shape.center)
        for s in shape.menisci
    )  # fmt: skip
    words(axes, theme, (start[0] + 0.1, start[1] + 0.2), "start clamp")
    words(axes, theme, (end[0] - 0.1, end[1] + 0.2), "end clamp")
    words(axes, theme, (a[0] - 0.13, a[1] + 0.12), r"$A$")
    words(axes, theme, (b[0] + 0.13, b[1] + 0.12), r"$B$")
    words(axes, theme, (-0.12, -0.22), "drop")
    arrow(axes, theme, (0.0, 0.0), (0.5 * np.cos(-0.6), 0.5 * np.sin(-0.6)))
    words(axes, theme, (0.28, -0.06), r"$D/2$")
    words(axes, theme, (0.72, -0.53), "soft wall (dots)", ha="left")
    arrow(axes, theme, (0.70, -0.50), (shape.wall * np.cos(-0.75), shape.wall * np.sin(-0.75)))
    low = DOWN + 0.25
    gap = length - float(end[0] - start[0])
    arrow(axes, theme, (start[0], low), (end[0], low), both=True)
    words(axes, theme, (0.5 * (start[0] + end[0]), low - 0.11), r"$\ell-\delta$")
    arrow(axes, theme, (end[0] + gap, low), (end[0], low))
    words(axes, theme, (end[0] + 0.5 * gap, low - 0.11), r"$\delta$")
    for x in (start[0], end[0], end[0] + gap):
        axes.plot([x, x], [low - 0.06, start[1] - 0.14], color=theme.faint, linewidth=0.8, zorder=1)
    arrow(axes, theme, (end[0] + 0.12, end[1]), (end[0] + 0.5, end[1]))
    words(axes, theme, (end[0] + 0.57, end[1]), r"$t$")
    turn = FancyArrowPatch(
        (end[0] + 0.24, end[1] - 0.15), (end[0] + 0.24, end[1] + 0.15), arrowstyle="-|>",
        connectionstyle="arc3,rad=0.7", mutation_scale=11, color=theme.ink, linewidth=1.0, zorder=7,
    )  # fmt: skip
    axes.add_patch(turn)
    words(axes, theme, (end[0] + 0.36, end[1] + 0.17), r"$\mathcal{R}$")
    top = float(eye.see(shape.positions - shape.center)[:, 1].max())
    words(axes, theme, (0.0, top + 0.11), r"rod of length $\ell$, wetted from $s_A$ to $s_B$")


def words(axes: Axes, theme: Theme, at: tuple[float, float], text: str, ha: str = "center") -> None:
    """A name."""
    axes.text(*at, text, color=theme.ink, fontsize=12, ha=ha, va="center", zorder=8)


def arrow(axes: Axes, theme: Theme, tail: Any, head: Any, both: bool = False) -> None:
    """A thin arrow, with two heads if ``both``."""
    patch = FancyArrowPatch(
        tail, head, arrowstyle="<|-|>" if both else "-|>", mutation_scale=11, color=theme.ink,
        linewidth=1.0, shrinkA=0, shrinkB=0, zorder=7,
    )  # fmt: skip
    axes.add_patch(patch)


def main(arguments: list[str] | None = None) -> int:
    """Draw the sketch of a run."""
    parser = argparse.ArgumentParser(description=__doc__)
    add_output(parser)
    args = parsed(parser, arguments)
    made = figure(derod.push(derod.Scene("quick", CHANGES)), THEMES[args.style])
    save(made, args.output, args.dpi, args.force)
    return 0


if __name__ == "__main__":
    sys.exit(started(main))
