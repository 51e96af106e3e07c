"""A phase diagram: which state, how many coils and what tension, over two keys of a sweep.

Points of a grid are cells, others dots; a sweep of one key whose pushes kept several rows has the
end-shortening as its second axis. Lines are special points of branch files of the same rod at other values
of the keys: pitchforks where two paths in the file meet, and folds, each joined to its nearest neighbour in
the next file.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import BoundaryNorm, ListedColormap
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from derod.exits import UsageError
from derod.sweeps.states import IN_SPACE, words
from derod.views.plots.kinds import Options
from derod.views.plots.style import Theme

SHORTENING = "end_shortening"
NEAR = 0.3
"""pi D: how far the points of two branch files may lie apart and be joined."""
SYMBOLS = {
    "drop.capillary_force": r"capillary force  $f_\gamma$   ($K_0/D^2$)",
    "rod.length": r"length  $\ell$   ($D$)",
    "drop.wall_strength": r"wall strength  $v_0$   ($K_0/D^2$)",
    "rod.twisting": r"twisting stiffness  $k_3$   ($K_0$)",
    "clamps.end_rotation": r"end rotation  $R$   (rad)",
    "drop.weight": r"weight  $W$   ($K_0/D^2$)",
    SHORTENING: r"end-shortening  $\delta/\pi$   ($D$)",
}
HUES = ("Ax", "Pt", "L2", "Tri1")
"""Of planar states with 0, 1, 2, 3 and more loops."""


def draw(
    figure: Figure, sweeps: Sequence[Any], branches: Sequence[Any], theme: Theme, options: Options
) -> None:
    """Three panels side by side."""
    sweep = sweeps[0]
    across, up = axes_of(sweep, options.keys)
    rows = sweep.rows
    if not len(rows):
        raise UsageError(f"{sweep.path}: no point completed: there is nothing to draw")
    figure.set_size_inches(11.5, 5.0)
    panels = figure.subplots(1, 3, sharex=True, sharey=True)
    x, y = column(rows, across), column(rows, up)
    states = np.minimum(rows["loops"], len(HUES) - 1)
    colors = [theme.paths["3D"], *(theme.paths[name] for name in HUES)]
    edges = np.arange(len(colors) + 1) - 1.5
    paint(panels[0], x, y, states, ListedColormap(colors), BoundaryNorm(edges, len(colors)))
    for axes, name, label in (
        (panels[1], "coils", "coils: total turning over $2\\pi$"),
        (panels[2], "end_tension", "tension  $t$   ($K_0/D^2$)"),
    ):
        painted = paint(axes, x, y, rows[name], theme.sequential, None)
        bar = figure.colorbar(painted, ax=axes, location="top", pad=0.02, aspect=28, shrink=0.96)
        bar.set_label(label)
        bar.outline.set_visible(False)
    low, high = panels[0].get_ylim()
    for kind, segments in lines(branches, across, up, NEAR):
        for axes in panels:
            draw_line(axes, kind, segments, theme)
    panels[0].set_ylim(low, high)
    panels[0].set_ylabel(SYMBOLS.get(up, up))
    for axes in panels:
        axes.set_xlabel(SYMBOLS.get(across, across))
    panels[0].set_title("state", fontsize=12)
    add_legend(figure, panels[0], sorted(set(states.tolist())), colors, theme)


def axes_of(sweep: Any, wanted: Sequence[str]) -> tuple[str, str]:
    """The columns on the level and the upright axis. Raises UsageError."""
    names = [name for name in sweep.rows.dtype.names if sweep.rows.dtype[name].kind in "if"]
    if wanted:
        for name in wanted:
            if name not in names:
                raise UsageError(f"keys = {name}: is no column of numbers in {sweep.path}")
        if len(wanted) != 2:
            raise UsageError(f"keys = {', '.join(wanted)}: allowed: two of them")
        return wanted[0], wanted[1]
    keys = [key for key in sweep.keys if key in names]
    if len(keys) == 1 and sweep.plan.rows != "last":
        return keys[0], SHORTENING
    if len(keys) != 2:
        raise UsageError(
            f"{sweep.path}: varies {', '.join(sweep.keys)}: choose two with --keys (keys=[...])"
        )
    return keys[0], keys[1]


def column(rows: np.ndarray, name: str) -> np.ndarray:
    """The values of an axis; end-shortenings over pi."""
    values = rows[name].astype(float)
    return np.asarray(values / np.pi if name == SHORTENING else values)


def paint(
    axes: Axes, x: np.ndarray, y: np.ndarray, values: np.ndarray, cmap: Any, norm: Any
) -> Any:
    """Cells where the points make a grid, else dots. Cells without a point stay empty."""
    columns, i = levels(x)
    lines, j = levels(y)
    if 3 * len(x) < len(columns) * len(lines):  # scattered
        return axes.scatter(x, y, c=values, cmap=cmap, norm=norm, s=22, linewidths=0, gid="points")
    cells = np.full((len(lines), len(columns)), np.nan)
    cells[j, i] = values
    return axes.pcolormesh(
        borders(columns), borders(lines), np.ma.masked_invalid(cells), cmap=cmap, norm=norm,
        rasterized=True, gid="cells",
    )  # fmt: skip


def levels(values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Distinct values, those equal but for rounding as one, and which of them each is."""
    rounded = np.round(values, 9)
    found, which = np.unique(rounded, return_inverse=True)
    return found, which


def borders(middles: np.ndarray) -> np.ndarray:
    """Borders of cells (n+1,) about their middles (n,)."""
    if len(middles) == 1:
        return np.array([middles[0] - 0.5, middles[0] + 0.5])
    between = 0.5 * (middles[1:] + middles[:-1])
    first, last = 2 * middles[0] - between[0], 2 * middles[-1] - between[-1]
    return np.concatenate([[first], between, [last]])


def lines(
    branches: Sequence[Any], across: str, up: str, near: float
) -> list[tuple[str, list[np.ndarray]]]:
    """Segments (2, 2) between special points of branch files, by kind: pitchforks and folds."""
    if not branches:
        return []
    name = across.partition(".")[2]
    if up != SHORTENING or not hasattr(branches[0].parameters, name):
        raise UsageError(
            f"{branches[0].path}: branches lie over the end-shortening and a key of the rod or the drop; "
            f"this diagram has {across} and {up}"
        )
    files = sorted((float(getattr(file.parameters, name)), special(file)) for file in branches)
    segments: dict[str, list[np.ndarray]] = {"pitchfork": [], "fold": []}
    for (x0, here), (x1, there) in pairwise(files):
        for group in here.keys() & there.keys():
            for a in here[group]:
                b = nearest(there[group], a)
                back = nearest(here[group], b)
                if back == a and abs(b - a) < near:
                    segments[group[0]].append(np.array([[x0, a], [x1, b]]))
    return list(segments.items())


def nearest(places: Sequence[float], place: float) -> float:
    """The one of ``places`` that is nearest."""
    return min(places, key=lambda other: abs(other - place))


def special(file: Any) -> dict[tuple[str, ...], list[float]]:
    """End-shortenings over pi of pitchforks by the two paths that meet there, and of folds by their path."""
    found: dict[tuple[str, ...], list[float]] = {}
    for name, branch in file.items():
        for row in branch.bifurcations:
            kind, partner = row["kind"].decode(), row["partner"].decode()
            if kind == "pitchfork" and partner:
                group: tuple[str, ...] = (kind, *sorted((name, partner)))
            elif kind == "fold":
                group = (kind, name)
            else:
                continue
            place = float(row["end_shortening"] / np.pi)
            points = found.setdefault(group, [])
            if not any(abs(place - other) < 1e-6 for other in points):
                points.append(place)
    return found


def draw_line(axes: Axes, kind: str, segments: list[np.ndarray], theme: Theme) -> None:
    """One kind of line, on a paler one so that it is seen on any colour."""
    for segment in segments:
        x, y = segment.T
        axes.plot(x, y, color=theme.paper, linewidth=2.6, alpha=0.7, zorder=5)
        axes.plot(x, y, color=theme.ink, linewidth=1.3, linestyle=STYLES[kind], gid=kind, zorder=6)


STYLES: dict[str, Any] = {"pitchfork": "-", "fold": (0, (1.2, 1.2))}


def add_legend(
    figure: Figure, axes: Axes, states: list[int], colors: list[str], theme: Theme
) -> None:
    """The states that occur, and what the lines are."""
    handles: list[Any] = [
        Patch(color=colors[n + 1], label=words(n) + (" or more" if n == len(HUES) - 1 else ""))
        for n in sorted(states, key=lambda n: (n == IN_SPACE, n))
    ]
    drawn = {line.get_gid() for line in axes.get_lines()}
    handles += [
        Line2D([], [], color=theme.ink, linewidth=1.3, linestyle=STYLES[kind], label=label)
        for kind, label in (
            ("pitchfork", "pitchfork, of the branches"),
            ("fold", "fold, of the branches"),
        )
        if kind in drawn
    ]
    figure.legend(
        handles=handles, loc="outside lower center", ncols=6, fontsize=9.5, handlelength=1.6,
        columnspacing=1.6,
    )  # fmt: skip
