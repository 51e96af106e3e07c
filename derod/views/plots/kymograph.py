"""Curvature and tension along the rod as images over delta; the lines are the menisci.

Arc length is counted from the rod's middle.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from derod.record.profiles import curvature, node_tension
from derod.views.plots.kinds import Options
from derod.views.plots.reading import abscissa
from derod.views.plots.style import LABELS, Theme

PIXELS = 500  # along the rod
MARGIN = 0.6  # D of outer rod that is shown


def images(run: Any, reach: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Arc length (P,) from the middle, D; curvature, 1/D, and tension, K0/D^2, there, (P, T)."""
    s = np.linspace(-reach, reach, PIXELS)
    middle = 0.5 * run.scene.rod.length
    kappa, tension = np.empty((PIXELS, len(run))), np.empty((PIXELS, len(run)))
    for i in range(len(run)):
        nodes = run.arc_length(i) - middle
        kappa[:, i] = np.interp(s, nodes, curvature(run.positions(i), run.arc_length(i)))
        tension[:, i] = np.interp(s, nodes, node_tension(run.edge_tension(i)))
    return s, kappa, tension


def reach_shown(run: Any) -> float:
    """How far from the middle the images go, D: the wetted rod and a little, all without a drop."""
    half = 0.5 * float(run.scene.rod.length)
    if run.scene.drop is None:
        return half
    return min(half, 0.5 * float(run.table["wetted_length"].max()) + MARGIN)


def draw(
    figure: Figure, runs: Sequence[Any], branches: Sequence[Any], theme: Theme, options: Options
) -> None:
    """Two images, one above the other, each with its scale."""
    run = runs[0]
    figure.set_size_inches(7.0, 6.2)
    panels = figure.subplots(2, 1, sharex=True)
    table, drop = run.table, run.scene.drop
    x, label = abscissa(run)
    half, reach = 0.5 * run.scene.rod.length, reach_shown(run)
    s, kappa, tension = images(run, reach)
    strong = float(np.abs(tension).max()) if drop is None else float(drop.capillary_force)
    scales = (
        (kappa, "curvature", theme.sequential, 0.0, float(np.percentile(kappa, 99.5))),
        (tension, "edge_tension", theme.diverging, -strong, strong),
    )
    for axes, (image, name, colors, low, high) in zip(panels, scales, strict=True):
        mesh = axes.pcolormesh(
            x, s, image, cmap=colors, vmin=low, vmax=max(high, low + 1e-12), shading="nearest",
            rasterized=True, gid=name,
        )  # fmt: skip
        extend = ("neither", "max", "min", "both")[
            2 * bool(image.min() < low) + bool(image.max() > high)
        ]
        figure.colorbar(mesh, ax=axes, label=LABELS[name], pad=0.015, extend=extend)
        for meniscus in ("meniscus_a", "meniscus_b") if drop is not None else ():
            axes.plot(x, table[meniscus] - half, color="#ffffff", linewidth=1.8, gid=meniscus)
            axes.plot(x, table[meniscus] - half, color="#1b1e23", linewidth=0.8, label="menisci")
        axes.set_ylabel(LABELS["s"])
        axes.set_ylim(-reach, reach)
    panels[-1].set_xlabel(label)
    panels[-1].set_xlim(float(x.min()), max(float(x.max()), float(x.min()) + 1e-9))
    if drop is not None:
        handles, labels = panels[0].get_legend_handles_labels()
        figure.legend(handles[:1], labels[:1], loc="outside upper right", fontsize=9.5)
