"""What uncertain values leave certain: t(delta) of a sampled sweep, with its bands."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from derod.sweeps.uncertainty import bands
from derod.views.plots.kinds import Options
from derod.views.plots.style import LABELS, Theme


def draw(
    figure: Figure, sweeps: Sequence[Any], branches: Sequence[Any], theme: Theme, options: Options
) -> None:
    """One panel: the middle, the band of one standard deviation, and that of two."""
    figure.set_size_inches(7.0, 4.6)
    axes = figure.subplots()
    sweep = sweeps[0]
    table = bands(sweep)
    x, color = table["end_shortening"] / np.pi, theme.paths["Ax"]
    wide, narrow, middle = (
        ("95 % of the samples", "68 % of the samples", "median")
        if sweep.plan.design != "differences"
        else (r"$\pm 2$ standard deviations", r"$\pm 1$ standard deviation", "nominal")
    )
    axes.fill_between(x, table["low_95"], table["high_95"], color=color, alpha=0.18, linewidth=0,
                      label=wide, gid="band 95")  # fmt: skip
    axes.fill_between(x, table["low_68"], table["high_68"], color=color, alpha=0.35, linewidth=0,
                      label=narrow, gid="band 68")  # fmt: skip
    axes.plot(x, table["middle"], color=color, linewidth=1.8, label=middle, gid="middle")
    axes.set_xlabel(LABELS["delta"])
    axes.set_ylabel(LABELS["end_tension"])
    axes.margins(x=0.02)
    failed = len(sweep.failures())
    title = f"{len(sweep)} pushes over {', '.join(sweep.keys)}"
    axes.set_title(title + (f"; {failed} did not complete" if failed else ""), fontsize=10)
    axes.legend(loc="lower right", fontsize=9.5)
