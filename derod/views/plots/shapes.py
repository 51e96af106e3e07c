"""The rod as a tube in its translucent drop, two views a state, menisci as beads.

States of a run are its increments nearest to the end-shortenings asked for; states of branches are
solved there. Where a branch file is given without names of paths, the state of lowest energy is shown.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from derod.exits import UsageError
from derod.views.plots.kinds import Options, file_name, written
from derod.views.plots.painter import RADIUS, paint_shape, turned
from derod.views.plots.path import family
from derod.views.plots.reading import Shape, label, landing_shapes, run_shape
from derod.views.plots.style import Theme, path_color

VIEWS = (0.35, 1.92)  # rad, the eye's turns from the coil's axis, about the clamps' axis
SHARES = (0.15, 0.4, 0.7, 1.0)  # of the end-shortenings of a file, shown where none is asked for
REACH = 0.78  # D, from the drop's centre, that is in view


def draw(
    figure: Figure, runs: Sequence[Any], branches: Sequence[Any], theme: Theme, options: Options
) -> None:
    """All states that were asked for, of runs and then of branches."""
    shapes: list[Shape] = []
    names: list[str] = []
    for run in runs:
        found = run_states(run, options.at)
        shapes += found
        names += [label(run) if len(runs) > 1 or branches else ""] * len(found)
    for file in branches:
        found = branch_states(file, options.at, options.paths)
        shapes += found
        names += [family(shape.name) for shape in found]
    draw_shapes(figure, shapes, names, theme)


def run_states(run: Any, at: Sequence[float]) -> list[Shape]:
    """The increments nearest to ``at`` (D) that the run has come to."""
    delta = run.table["end_shortening"]
    low, high = float(delta.min()), float(delta.max())
    places = [x for x in at if low - 1e-9 <= x <= high + 1e-9] if at else spread(low, high)
    return [run_shape(run, x) for x in places]


def branch_states(file: Any, at: Sequence[float], paths: Sequence[str]) -> list[Shape]:
    """The states of ``paths`` on all their sheets; without names, that of lowest energy of all."""
    tables = [file[name].table["end_shortening"] for name in paths or file.keys()]
    places = at or spread(min(t.min() for t in tables), max(t.max() for t in tables))
    out: list[Shape] = []
    for delta in places:
        found = [s for name in paths or file.keys() for s in landing_shapes(file[name], delta)]
        if not paths and found:
            found = [min(found, key=lambda shape: shape.energy_hat)]
        out += found
    if not out:
        raise UsageError(
            f"{file_name(file)}: at = {', '.join(map(written, places))}: "
            "no branch could be solved there"
        )
    return out


def spread(low: float, high: float) -> list[float]:
    """A few end-shortenings (D) between the least and the largest."""
    return [low + share * (high - low) for share in SHARES]


def draw_shapes(
    figure: Figure, shapes: Sequence[Shape], names: Sequence[str], theme: Theme, columns: int = 4
) -> None:
    """Each shape in two views, one below the other, titled by its numbers."""
    columns = min(columns, len(shapes))
    rows = -(-len(shapes) // columns)
    height = 6.5 * rows + 0.4
    figure.set_size_inches(max(3.6 * columns, 4.4), height)
    figure.set_layout_engine("none")
    outer = figure.add_gridspec(
        rows, columns, left=0, right=1, bottom=0.35 / height, top=1 - 0.6 / height,
        hspace=0.6 / 5.9, wspace=0.02,
    )  # fmt: skip
    for number, (shape, name) in enumerate(zip(shapes, names, strict=True)):
        cell = outer[divmod(number, columns)].subgridspec(2, 1, hspace=0.02)
        facing = coil_angle(shape)
        reach = REACH if shape.wet else 0.55 * float(np.ptp(shape.positions[:, 2]))
        color = path_color(theme, shape.name or "3D")
        for k, turn in enumerate(VIEWS):
            axes = figure.add_subplot(cell[k])
            paint_shape(
                axes, shape, turned(facing + turn), theme, color, RADIUS * reach / REACH, reach
            )
            axes.set_gid(f"view {k}")
            if k == 0:
                axes.set_title(title(shape, name), fontsize=11, pad=2)
    words = "two views of each state"
    if any(shape.wet for shape in shapes):
        words += r"; the drop's diameter is $D$, beads are the menisci, dots the soft wall's edge"
    figure.text(0.5, 0.12 / height, words, ha="center", fontsize=9.5, gid="caption")


def coil_angle(shape: Shape) -> float:
    """The direction about the clamps' axis in which the coil is thinnest, radians.

    Solutions may be turned about the axis at no cost; this makes their pictures comparable.
    """
    x = shape.positions - shape.center
    spread_across = np.cov(x[shape.coiled][:, :2].T)
    _, modes = np.linalg.eigh(spread_across)
    return float(np.arctan2(modes[1, 0], modes[0, 0]))


def title(shape: Shape, name: str = "") -> str:
    """Which state this is, in two lines."""
    head = f"{name}:  " if name else ""
    return (
        rf"{head}$\delta$ = {shape.end_shortening / np.pi:.4g}$\,\pi$"
        rf" = {shape.end_shortening:.4g}$\,D$"
        "\n"
        rf"$t = {shape.end_tension:.2f}\,K_0/D^2$,  $\hat{{E}} = {shape.energy_hat:.2f}\,K_0/D$"
    )
