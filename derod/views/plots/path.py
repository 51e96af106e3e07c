"""t and E_hat against delta/pi: branches and runs, their stability, bifurcations and events.

Hues are paths, dashes are instability; crosses are pitchforks, dots are the increments of a push, diamonds
the states that were asked for. The limits show every stable state, every run and every special point;
what is far beyond them (a tension that grows without bound) runs out of the picture.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from derod.views.plots.kinds import Options
from derod.views.plots.reading import HARD_WALL, label, run_shape, stretches
from derod.views.plots.specials import draw_events, draw_specials, special_points
from derod.views.plots.style import LABELS, Theme, path_color

QUANTITIES = ("end_tension", "energy_hat")
DASHES = (0, (4, 2))
RUN_HUES = ("run", "L2", "Ax", "Pt", "Tri1")
NEAR, BEYOND = 0.8, 0.2
"""In spans of what must be seen: unstable states as near as NEAR are shown too; if there are any further out,
the limit is BEYOND it."""


def draw(
    figure: Figure, runs: Sequence[Any], branches: Sequence[Any], theme: Theme, options: Options
) -> None:
    """Two panels, one above the other, and a legend above them."""
    figure.set_size_inches(7.0, 7.6)
    panels = figure.subplots(len(QUANTITIES), 1, sharex=True)
    for axes, quantity in zip(panels, QUANTITIES, strict=True):
        for file in branches:
            for name in options.paths or file.keys():
                draw_branch(axes, name, file[name], theme, quantity)
            draw_specials(axes, file, theme, quantity, options.paths)
        for number, run in enumerate(runs):
            draw_run(axes, run, theme, quantity, number, points=bool(branches))
            draw_events(axes, run, theme, quantity)
            draw_states(axes, run, theme, quantity, options.at)
        if quantity == "end_tension":
            draw_plateau(axes, runs, branches, theme)
        axes.set_ylabel(LABELS[quantity])
        axes.set_ylim(*limits(runs, branches, quantity, options.paths))
        axes.margins(x=0.02)
    panels[-1].set_xlabel(LABELS["delta"])
    add_legend(figure, panels[0])


def draw_branch(axes: Axes, name: str, branch: Any, theme: Theme, quantity: str) -> None:
    """A path: solid where it is stable, dashed where not.

    Where nobody counted the unstable modes it is drawn as the paper does: planar paths dashed.
    """
    table = branch.table
    modes = table["unstable_modes"]
    counted = bool((modes >= 0).all())
    solid = modes == 0 if counted else np.full(len(modes), name.startswith(("3D", "Tri")))
    text: str | None = family(name)
    if text in [line.get_label() for line in axes.get_lines()]:
        text = None
    for first, last, full in stretches(solid, branch.bifurcations["index"]):
        kind = ("stable" if full else "unstable") if counted else ("space" if full else "planar")
        axes.plot(
            table["end_shortening"][first : last + 1] / np.pi,
            table[quantity][first : last + 1],
            color=path_color(theme, name),
            linestyle="-" if full else DASHES,
            linewidth=2.2 if full and counted else 1.1,
            label=text,
            gid=f"branch {name} {kind}",
            zorder=4 if full else 3,
        )
        text = None


def family(name: str) -> str:
    """The path's name in the paper, as the legend has it."""
    if name.startswith("3D"):
        return "3D"
    return {"Ax": r"$Ax$", "L2": r"$L_2$", "Pt": r"$P_t$"}.get(name, name)


def draw_run(
    axes: Axes, run: Any, theme: Theme, quantity: str, number: int = 0, *, points: bool
) -> None:
    """A push: dots beside branches, else a line, dashed where an increment has unstable modes."""
    table = run.table
    x, y = table["end_shortening"] / np.pi, table[quantity]
    color = theme.paths[RUN_HUES[number % len(RUN_HUES)]]
    if points or len(table) < 2:
        axes.plot(
            x, y, ".", markersize=3.6, markeredgewidth=0, color=color,
            label=f"push: {label(run)}", gid=f"run {number}", zorder=7,
        )  # fmt: skip
        return
    stable = (table["unstable_modes"] == 0) & ~table["slides"]
    text: str | None = f"push: {label(run)}"
    for first, last, full in stretches(stable):
        axes.plot(
            x[first : last + 1], y[first : last + 1], color=color, label=text,
            linestyle="-" if full else DASHES, linewidth=1.9 if full else 1.1,
            gid=f"run {number} {'stable' if full else 'unstable'}", zorder=4,
        )  # fmt: skip
        text = None


def draw_states(axes: Axes, run: Any, theme: Theme, quantity: str, at: Sequence[float]) -> None:
    """The increments nearest to the end-shortenings (D) that were asked for, as diamonds."""
    if at:
        shapes = [run_shape(run, delta) for delta in at]
        axes.plot(
            [shape.end_shortening / np.pi for shape in shapes],
            [getattr(shape, quantity) for shape in shapes],
            "D", markersize=7, color="#f2c14e", markeredgecolor="#6b4e00", linestyle="none",
            label="states asked for", gid="states", zorder=9,
        )  # fmt: skip


def draw_plateau(axes: Axes, runs: Sequence[Any], branches: Sequence[Any], theme: Theme) -> None:
    """The tension of the hard-wall limit, f_gamma - 2."""
    forces = {run.scene.drop.capillary_force for run in runs if run.scene.drop is not None}
    forces |= {file.parameters.capillary_force for file in branches}
    for force in forces:
        axes.axhline(
            force - HARD_WALL, color=theme.faint, linewidth=1.0, zorder=1, gid="plateau",
            label=r"hard wall, $t=f_\gamma-2$",
        )  # fmt: skip


def limits(
    runs: Sequence[Any], branches: Sequence[Any], quantity: str, paths: Sequence[str] = ()
) -> tuple[float, float]:
    """Limits of an axis that show every run, stable state and special point, and what is near."""
    seen = [run.table[quantity] for run in runs]
    everything = list(seen)
    for file in branches:
        for name in paths or file.keys():
            table = file[name].table
            everything.append(table[quantity])
            seen.append(table[quantity][table["unstable_modes"] == 0])
        for points in special_points(file, paths).values():
            seen += [np.array([row[quantity] for row in points])]
    must = np.concatenate([part for part in seen if len(part)] or everything)
    all_values = np.concatenate(everything)
    span = max(float(must.max() - must.min()), 1e-3)
    low, high = float(must.min()), float(must.max())
    below, above = low - float(all_values.min()), float(all_values.max()) - high
    low -= below if below <= NEAR * span else BEYOND * span
    high += above if above <= NEAR * span else BEYOND * span
    return min(low - 0.04 * span, 0.0 if low >= 0.0 else low), high + 0.06 * span


def add_legend(figure: Figure, axes: Axes) -> None:
    """One legend above the panels: each label once, lines plain, and what dashes mean."""
    shown = dict(zip(*reversed(axes.get_legend_handles_labels()), strict=True))
    handles = []
    for text, line in shown.items():
        plain = Line2D([], [])
        plain.update_from(line)
        if line.get_marker() in ("None", None, "") and line.get_gid() != "plateau":
            plain.set(linestyle="-", linewidth=2.2)
        plain.set_label(text)
        handles.append(plain)
    ink = axes.yaxis.label.get_color()
    for kind in ("unstable", "planar"):
        if any((line.get_gid() or "").endswith(f" {kind}") for line in axes.get_lines()):
            handles += [Line2D([], [], color=ink, linewidth=1.1, linestyle=DASHES, label=kind)]
    figure.legend(
        handles=handles, loc="outside upper center", ncols=4, fontsize=9.5, handlelength=2.2
    )
