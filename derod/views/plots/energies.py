"""The parts of E_hat along a push, stacked, and their sum."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from derod.views.plots.kinds import Options
from derod.views.plots.reading import abscissa, event_row
from derod.views.plots.style import LABELS, Theme

NAMES = {
    "bend": "bending",
    "twist": "twist",
    "wall": "soft wall",
    "capillary": r"capillary, $f_\gamma(\delta+1-\ell_{in})$",
}
LINES = {"instability": "kick", "snap": "snap", "turn": "turn"}


def parts(run: Any) -> dict[str, np.ndarray]:
    """Parts (T,), K0/D, that add up to E_hat; the capillary one holds the reference
    f_gamma (delta + 1). A rod without a drop has bending and twist only.
    """
    table, drop = run.table, run.scene.drop
    out = {"bend": table["energy_bend"], "twist": table["energy_twist"]}
    if drop is not None:
        lifted = drop.capillary_force * (table["end_shortening"] + 1)
        out["wall"] = table["energy_wall"]
        out["capillary"] = table["energy_capillary"] + lifted
    return out


def draw(
    figure: Figure, runs: Sequence[Any], branches: Sequence[Any], theme: Theme, options: Options
) -> None:
    """Stacked parts and their sum against delta/pi, events marked."""
    run = runs[0]
    figure.set_size_inches(7.0, 4.6)
    axes = figure.subplots()
    x, label = abscissa(run)
    stacked = parts(run)
    for band, name in zip(
        axes.stackplot(
            x,
            *stacked.values(),
            labels=[NAMES[name] for name in stacked],
            colors=theme.parts,
            alpha=0.85,
            linewidth=0,
        ),
        stacked,
        strict=True,
    ):
        band.set_gid(f"part {name}")
    total = r"$\hat{E}$" if run.scene.drop is not None else r"$E$"
    axes.plot(
        x, run.table["energy_hat"], color=theme.ink, linewidth=1.6, label=total, gid="energy_hat"
    )
    mark_events(axes, run, x, theme)
    first = 0.0 if 0.0 < x.min() < 0.02 * x.max() else float(x.min())
    axes.set_xlim(first, max(float(x.max()), float(x.min()) + 1e-9))
    axes.set_ylim(0, 1.04 * max(float(run.table["energy_hat"].max()), 1e-9))
    axes.set_xlabel(label)
    axes.set_ylabel(LABELS["energy_hat"] if run.scene.drop is not None else LABELS["energy"])
    figure.legend(loc="outside upper center", ncols=3, fontsize=9.5)


def mark_events(axes: Axes, run: Any, x: np.ndarray, theme: Theme) -> None:
    """Kicks, snaps and turns as dotted lines, their names above the panel: nothing is covered."""
    for event in run.events:
        if event.kind in LINES:
            where = float(x[event_row(run, event)])
            axes.axvline(where, color=theme.ink, linewidth=0.8, linestyle=(0, (2, 3)), gid="event")
            axes.annotate(
                LINES[event.kind],
                (where, 1.0),
                xycoords=("data", "axes fraction"),
                xytext=(0, 2),
                textcoords="offset points",
                ha="center",
                fontsize=9,
            )
