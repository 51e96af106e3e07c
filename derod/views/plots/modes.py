"""The softest modes at given end-shortenings: how the rod moves, seen and along its length.

Each mode is a column: the rod, coloured by how far it moves, between where the mode takes it and its
opposite; below, the displacement along three directions against arc length from the middle. The largest
of these is 1. Without end-shortenings the last increment is shown.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from derod.scene.axis import END_SHORTENING, axis_of
from derod.views.plots.kinds import Options
from derod.views.plots.painter import RADIUS, finer, paint_shape, turned
from derod.views.plots.path import DASHES
from derod.views.plots.reading import Shape, run_shape_at
from derod.views.plots.shapes import REACH, VIEWS, coil_angle
from derod.views.plots.style import LABELS, Theme

if TYPE_CHECKING:
    from derod.record.modes import Modes

SWING = 0.1  # D that the largest component takes the rod to each side
DIRECTIONS = ("the coil's thinnest direction", "across it", "along the clamps' axis")
COLUMN, VIEW, CURVES, HEAD, LABEL, FOOT = 3.5, 2.5, 1.75, 0.95, 0.6, 0.75  # inches


def draw(
    figure: Figure, runs: Sequence[Any], branches: Sequence[Any], theme: Theme, options: Options
) -> None:
    """A band of modes for each end-shortening asked for."""
    run = runs[0]
    delta = run.table["end_shortening"]
    places = [int(np.argmin(abs(delta - x))) for x in options.at] or [len(run) - 1]
    band = HEAD + len(VIEWS) * VIEW + CURVES + LABEL
    width, height = COLUMN * max(options.modes, 2), band * len(places) + FOOT
    figure.set_size_inches(width, height)
    figure.set_layout_engine("none")
    for number, i in enumerate(places):
        top = 1 - number * band / height
        grid = figure.add_gridspec(
            len(VIEWS) + 1, options.modes, left=0.6 / width, right=1 - 0.1 / width,
            top=top - HEAD / height, bottom=top - (band - LABEL) / height,
            height_ratios=[*[VIEW] * len(VIEWS), CURVES], hspace=0.04, wspace=0.12,
        )  # fmt: skip
        shape, found = run_shape_at(run, i), run.modes(i, options.modes)
        figure.text(0.5, top - 0.3 / height, heading(run, i), ha="center", gid=f"state {number}")
        for k, value in enumerate(found.eigenvalues):
            draw_views(
                figure, [grid[row, k] for row in range(len(VIEWS))], shape, found.shapes[k], theme
            )
            figure.axes[-len(VIEWS)].set_title(
                rf"$\lambda_{{{k + 1}}}$ = {value:.4g}$\,K_0/D^4${parity(found, k)}", fontsize=11, pad=2,
                color=theme.event if value < 0 else theme.ink,
            )  # fmt: skip
            draw_components(
                figure.add_subplot(grid[-1, k]), shape, found.shapes[k], theme, first=k == 0
            )
    add_legend(figure, theme)


def parity(found: Modes, k: int) -> str:
    """How mode k stands to the state's symmetries, as a second line; empty where it has none."""
    words = [f"flip-{found.flip[k]}"] if found.flip[k] else []
    words += [{"in": "in the plane", "out": "out of it"}.get(found.plane[k], found.plane[k])]
    words = [word for word in words if word]
    return f"\n{', '.join(words)}" if words else ""


def add_legend(figure: Figure, theme: Theme) -> None:
    """What the lines are, below everything."""
    handles, _ = figure.axes[-1].get_legend_handles_labels()
    handles += [
        Line2D([], [], color=theme.event, linewidth=1.0, label="where the mode takes the rod"),
        Line2D([], [], color=theme.event, linewidth=0.8, linestyle=DASHES, label="its opposite"),
    ]
    columns = 3 if len(handles) > 4 else len(handles)
    figure.legend(handles=handles, loc="lower center", ncols=columns, fontsize=9.5)


def heading(run: Any, i: int) -> str:
    """Which state this is."""
    row = run.table[i]
    count = int(row["unstable_modes"])
    words = "stable" if count == 0 else f"{count} unstable mode{'s' * (count > 1)}"
    axis = axis_of(run.scene, int(row["segment"]))
    value = float(row[axis.column])
    where = f"{axis.name} {axis.both(value)}"
    if axis is END_SHORTENING:
        where = rf"$\delta$ = {value / np.pi:.4g}$\,\pi$ = {value:.4g}$\,D$"
    return rf"{where},  $t = {row['end_tension']:.2f}\,K_0/D^2$,  {words}"


def draw_views(
    figure: Figure, cells: Sequence[Any], shape: Shape, mode: np.ndarray, theme: Theme
) -> None:
    """The rod from two sides, coloured by how far ``mode`` (N+1, 3) moves it, and where it takes it."""
    reach = REACH if shape.wet else 0.55 * float(np.ptp(shape.positions[:, 2]))
    radius = RADIUS * reach / REACH
    far = np.linalg.norm(mode, axis=1)
    colors = mpl.colormaps[theme.sequential](far / max(float(far.max()), 1e-300))[:, :3]
    facing = coil_angle(shape)
    for cell, turn in zip(cells, VIEWS, strict=True):
        axes = figure.add_subplot(cell)
        eye = turned(facing + turn)
        paint_shape(axes, shape, eye, theme, colors, radius, reach)
        for sign in (1, -1):
            moved = replace(shape, positions=shape.positions + sign * SWING * reach / REACH * mode)
            points, _ = finer(moved.positions - shape.center, shape.arc_length)
            seen = eye.see(points)
            axes.plot(
                seen[:, 0], seen[:, 1], color=theme.event, linewidth=1.0 if sign > 0 else 0.8,
                linestyle="-" if sign > 0 else DASHES, gid=f"moved {sign:+d}", zorder=6.5,
            )  # fmt: skip


def draw_components(
    axes: Axes, shape: Shape, mode: np.ndarray, theme: Theme, *, first: bool
) -> None:
    """The displacement along three directions against arc length from the middle; wetted rod shaded."""
    s = shape.arc_length - 0.5 * float(shape.arc_length[-1])
    angle = coil_angle(shape)
    thin = np.array([np.cos(angle), np.sin(angle), 0.0])
    frame = np.stack([thin, np.cross([0.0, 0.0, 1.0], thin), [0.0, 0.0, 1.0]])
    if shape.wet:
        menisci = np.array(shape.menisci) - 0.5 * float(shape.arc_length[-1])
        axes.axvspan(*menisci, color=theme.water, alpha=0.25, linewidth=0, label="in the drop")
    axes.axhline(0, color=theme.faint, linewidth=0.8)
    hues = (theme.paths["3D"], theme.paths["Ax"], theme.paths["L2"])
    parts = frame @ mode.T
    parts /= max(float(np.abs(parts).max()), 1e-300)
    for name, values, color in zip(DIRECTIONS, parts, hues, strict=True):
        axes.plot(s, values, color=color, linewidth=1.5, label=name, gid=f"component {name}")
    axes.set_xlim(float(s[0]), float(s[-1]))
    axes.set_ylim(-1.12, 1.12)
    axes.set_xlabel(LABELS["s"])
    if first:
        axes.set_ylabel("displacement")
    else:
        axes.tick_params(labelleft=False)
