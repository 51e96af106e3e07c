"""The lowest eigenvalues of a push against delta: how soft its states are, and where they lose stability.

They are computed for the picture (``run.modes``), every n-th increment and always the last. An
eigenvalue below zero is an unstable mode; the states asked for are marked.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from derod.views.plots.energies import mark_events
from derod.views.plots.kinds import Options
from derod.views.plots.reading import abscissa
from derod.views.plots.style import LABELS, Theme


def lowest(run: Any, every: int, count: int) -> tuple[np.ndarray, np.ndarray]:
    """Increments (n,), and their ``count`` lowest eigenvalues (n, count), K0/D^4."""
    increments = np.union1d(np.arange(0, len(run), every), [len(run) - 1])
    return increments, np.array([run.modes(int(i), count).eigenvalues for i in increments])


def draw(
    figure: Figure, runs: Sequence[Any], branches: Sequence[Any], theme: Theme, options: Options
) -> None:
    """A line an eigenvalue; the unstable half is tinted where there is any."""
    run = runs[0]
    figure.set_size_inches(7.0, 4.6)
    axes = figure.subplots()
    x, label = abscissa(run)
    increments, values = lowest(run, options.every, options.modes)
    hues = [theme.paths[name] for name in ("Ax", "3D", "L2", "Pt", "Tri1", "Tri2")]
    for k, line in enumerate(values.T):
        axes.plot(
            x[increments], line, ".-", color=hues[k % len(hues)], linewidth=1.5, markersize=3,
            label=rf"$\lambda_{{{k + 1}}}$", gid=f"eigenvalue {k}", zorder=5 - 0.01 * k,
        )  # fmt: skip
    span = max(float(values.max() - min(values.min(), 0.0)), 1e-9)
    low = min(float(values.min()) - 0.05 * span, 0.0)
    axes.set_ylim(low, float(values.max()) + 0.05 * span)
    if low < 0:
        axes.axhspan(
            low, 0, color=theme.event, alpha=0.08, linewidth=0, label="unstable", gid="unstable"
        )
        axes.axhline(0, color=theme.ink, linewidth=0.8)
    mark_events(axes, run, x, theme)
    if options.at:
        delta = run.table["end_shortening"]
        asked = [int(np.argmin(abs(delta - place))) for place in options.at]
        axes.plot(
            x[asked], [run.modes(i, 1).eigenvalues[0] for i in asked], "D", markersize=7,
            color="#f2c14e", markeredgecolor="#6b4e00", linestyle="none", label="states asked for",
            gid="states", zorder=9,
        )  # fmt: skip
    axes.set_xlim(float(x.min()), max(float(x.max()), float(x.min()) + 1e-9))
    axes.set_xlabel(label)
    axes.set_ylabel(LABELS["eigenvalue"])
    figure.legend(loc="outside upper center", ncols=5, fontsize=9.5)
