"""A push held against the branches: the error of every increment, coloured by the path it lies on."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from derod.branches import compare
from derod.views.plots.kinds import Options
from derod.views.plots.path import family
from derod.views.plots.reading import label
from derod.views.plots.style import LABELS, Theme, path_color

PANELS = {
    "tension_error": r"$|\Delta t|\,/\,\max(1,|t|)$",
    "energy_error": r"$|\Delta\hat{E}|\,/\,\max(1,|\hat{E}|)$",
    "wetted_error": r"$|\Delta\ell_{in}|$   ($D$)",
    "shape_error": r"$\max|\Delta\mathbf{r}|$   ($D$)",
}
TOLERANCE = 5e-4  # of derod compare, if it is told none; for lengths twice that, in D
MARKERS = ("o", "s", "^", "v", "D")
LEAST = 1e-12  # a logarithmic axis has no zero


def draw(
    figure: Figure, runs: Sequence[Any], branches: Sequence[Any], theme: Theme, options: Options
) -> None:
    """Compare the runs with the branches and draw one panel an error."""
    results = [(label(run), compare(run, branches[0], options.every)) for run in runs]
    draw_errors(figure, results, theme)


def draw_errors(figure: Figure, results: Sequence[tuple[str, np.ndarray]], theme: Theme) -> None:
    """One panel an error over delta/pi; ``results`` are labels of runs and arrays of ``compare``."""
    figure.set_size_inches(7.0, 8.4)
    panels = figure.subplots(len(PANELS), 1, sharex=True)
    for axes, (name, text) in zip(panels, PANELS.items(), strict=True):
        limit = TOLERANCE * (2 if text.endswith("($D$)") else 1)
        for number, (run, rows) in enumerate(results):
            marker = MARKERS[number % len(MARKERS)]
            draw_rows(axes, rows, name, marker, f"{run}, " if len(results) > 1 else "", theme)
        axes.axhline(
            limit,
            color=theme.faint,
            linewidth=1.2,
            gid="tolerance",
            label="tolerance of derod compare",
        )
        axes.set_yscale("log")
        axes.set_ylabel(text)
    panels[-1].set_xlabel(LABELS["delta"])
    handles, labels = panels[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside upper center", ncols=5, fontsize=9.5)


def draw_rows(axes: Axes, rows: np.ndarray, name: str, marker: str, run: str, theme: Theme) -> None:
    """The rows of one run, path by path; those on no branch as crosses in the events' colour."""
    for path in dict.fromkeys(rows["branch"].tolist()):
        of_path = rows[rows["branch"] == path]
        axes.plot(
            of_path["end_shortening"] / np.pi,
            np.maximum(of_path[name], LEAST),
            marker if path else "x",
            markersize=3.0 if path else 5.0,
            markerfacecolor=theme.paper if "-" in path else None,  # 3D-L2 has the colour of 3D
            linestyle="none",
            color=path_color(theme, path) if path else theme.event,
            label=f"{run}on {family(path) if not path.startswith('3D') else path}"
            if path
            else f"{run}on no branch: the nearest",
            gid=f"rows {path}",
        )
