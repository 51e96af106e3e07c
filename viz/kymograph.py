"""Curvature and tension along the rod as images over delta: ``python viz/kymograph.py RUN.h5 -o
OUT.pdf``.

Arc length is counted from the rod's middle; the lines are the menisci.
"""

from __future__ import annotations

import argparse
import sys
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from reading import open_files
from style import LABELS, THEMES, Theme, add_output, new_figure, parsed, save, started, use

from derod.stream.fields import curvature, node_tension

PIXELS = 500  # along the rod


def images(run: Any, reach: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Arc length (P,) from the middle, and curvature and tension (P, T) there."""
    s = np.linspace(-reach, reach, PIXELS)
    middle = 0.5 * run.scene.rod.length
    kappa, tension = np.empty((PIXELS, len(run))), np.empty((PIXELS, len(run)))
    for i in range(len(run)):
        nodes = run.arc_length(i) - middle
        kappa[:, i] = np.interp(s, nodes, curvature(run.positions(i), run.arc_length(i)))
        tension[:, i] = np.interp(s, nodes, node_tension(run.edge_tension(i)))
    return s, kappa, tension


def figure(run: Any, theme: Theme) -> Figure:
    """Two images, one above the other."""
    use(theme)
    made = new_figure(6.8, 6.0)
    panels = made.subplots(2, 1, sharex=True)
    table = run.table
    delta = table["end_shortening"] / np.pi
    half = 0.5 * run.scene.rod.length
    reach = min(half, 0.5 * float(table["wetted_length"].max()) + 0.6)
    s, kappa, tension = images(run, reach)
    force = run.scene.drop.capillary_force
    scales = (
        (kappa, "curvature", theme.sequential, 0.0, float(np.percentile(kappa, 99.5))),
        (tension, "edge_tension", theme.diverging, -force, force),
    )
    for axes, (image, name, colors, low, high) in zip(panels, scales, strict=True):
        mesh = axes.pcolormesh(
            delta, s, image, cmap=colors, vmin=low, vmax=high, shading="nearest", rasterized=True
        )
        made.colorbar(
            mesh, ax=axes, label=LABELS[name], pad=0.015, extend="max" if low == 0 else "neither"
        )
        for meniscus in ("meniscus_a", "meniscus_b"):
            line = axes.plot(delta, table[meniscus] - half, color="#ffffff", linewidth=1.6)[0]
            line.set_gid(meniscus)
            axes.plot(delta, table[meniscus] - half, color="#1b1e23", linewidth=0.7)
        axes.set_ylabel(LABELS["s"])
        axes.set_ylim(-reach, reach)
    panels[-1].set_xlabel(LABELS["delta"])
    panels[-1].set_xlim(delta.min(), delta.max())
    return made


def main(arguments: list[str] | None = None) -> int:
    """Draw the images of a run."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("file", help="run file (HDF5)")
    add_output(parser)
    args = parsed(parser, arguments)
    save(
        figure(open_files([args.file]).runs[0], THEMES[args.style]),
        args.output,
        args.dpi,
        args.force,
    )
    return 0


if __name__ == "__main__":
    sys.exit(started(main))
