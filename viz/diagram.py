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
from matplotlib.lines import Line2D
from reading import HARD_WALL, branch_shape, open_files, stretches
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

QUANTITIES = ("end_tension", "energy_hat")
DASHES = (0, (4, 2))
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


def add_legend(made: Figure, axes: Axes) -> None:
    """One legend above the panels: hues are paths, dashes are instability."""
    shown = dict(zip(*reversed(axes.get_legend_handles_labels()), strict=True))
    handles = []
    for label, line in shown.items():
        plain = Line2D([], [])
        plain.update_from(line)
        if line.get_marker() in ("None", None, ""):
            plain.set(linestyle="-", linewidth=2.2)
        plain.set_label(label)
        handles.append(plain)
    ink = axes.yaxis.label.get_color()
    for kind in ("unstable", "planar"):
        if any((line.get_gid() or "").endswith(f" {kind}") for line in axes.get_lines()):
            dashed = Line2D([], [], color=ink, linewidth=1.1, linestyle=DASHES, label=kind)
            handles.append(dashed)
    made.legend(
        handles=handles, loc="outside upper center", ncols=5, fontsize=9.5, handlelength=2.2
    )


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


def draw_branch(axes: Axes, name: str, branch: Any, theme: Theme, quantity: str) -> None:
    """A path: solid where it is stable, dashed where not.

    Where nobody counted the unstable modes it is drawn as the paper does: planar paths dashed.
    """
    table = branch.table
    modes = table["unstable_modes"]
    counted = bool((modes >= 0).all())
    solid = modes == 0 if counted else np.full(len(modes), name.startswith(("3D", "Tri")))
    label: str | None = family(name)
    if label in [line.get_label() for line in axes.get_lines()]:
        label = None
    for first, last, full in stretches(solid, branch.bifurcations["index"]):
        kind = ("stable" if full else "unstable") if counted else ("space" if full else "planar")
        axes.plot(
            table["end_shortening"][first : last + 1] / np.pi,
            table[quantity][first : last + 1],
            color=path_color(theme, name),
            linestyle="-" if full else DASHES,
            linewidth=2.2 if full and counted else 1.1,
            label=label,
            gid=f"branch {name} {kind}",
            zorder=4 if full else 3,
        )
        label = None


def family(name: str) -> str:
    """The path's name in the paper, as the legend has it."""
    if name.startswith("3D"):
        return "3D"
    return {"Ax": r"$Ax$", "L2": r"$L_2$", "Pt": r"$P_t$"}.get(name, name)


def draw_specials(axes: Axes, file: Any, theme: Theme, quantity: str) -> None:
    """Pitchforks between stored paths and folds."""
    for kind, marker, size in (("pitchfork", "o", 5.0), ("fold", "|", 8.0)):
        points = [
            (row["end_shortening"] / np.pi, row[quantity])
            for branch in file.values()
            for row in branch.bifurcations
            if row["kind"].decode() == kind and (kind == "fold" or row["partner"])
        ]
        if points:
            axes.plot(
                *np.array(points).T,
                marker,
                markersize=size,
                color=theme.paper if kind == "pitchfork" else theme.ink,
                markeredgecolor=theme.ink,
                markeredgewidth=1.0,
                linestyle="none",
                label=kind if axes.get_subplotspec().rowspan.start == 0 else None,
                gid=f"specials {kind}",
                zorder=6,
            )


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


def draw_plateau(axes: Axes, runs: Sequence[Any], branches: Sequence[Any], theme: Theme) -> None:
    """The tension of the hard-wall limit, f_gamma - 2."""
    forces = {run.scene.drop.capillary_force for run in runs if run.scene.drop is not None}
    forces |= {file.parameters.capillary_force for file in branches}
    for force in forces:
        axes.axhline(force - HARD_WALL, color=theme.faint, linewidth=1.0, zorder=1, gid="plateau")
        axes.annotate(
            r"$f_\gamma-2$",
            (1.0, force - HARD_WALL),
            xycoords=("axes fraction", "data"),
            xytext=(-2, 3),
            textcoords="offset points",
            ha="right",
            fontsize=9.5,
            color=theme.ink,
            alpha=0.7,
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
