"""Draw where the planar state Pt of a flat strip is unstable, over K2/K1 and K3/K1.

    python runs/strip_map.py [-o docs/images/strip-map.png]

v0 = 2e-2, f_gamma = 20, rho = 0.1, l = 10; Pt bends about d_1 (alpha_0 = pi/2). Colours count the modes out
of its plane (flip-even and flip-odd), each panel's heading those in it; incompressible rectangles are marked.
"""

from __future__ import annotations

import argparse
import math
from dataclasses import replace
from pathlib import Path

import numpy as np
from two_stiffnesses import ROD, SIDEWAYS, torsion

from derod.branches.half_rod.mesh import halved
from derod.branches.half_rod.state import HalfRod
from derod.branches.half_rod.wall_core import CORE
from derod.branches.paths.catalogue import Catalogue
from derod.branches.paths.planar_modes import planar_modes

DELTAS = (0.25, 0.5, 1.0)
HALVINGS = 3
ASPECTS = (1, 1.5, 2, 3, 4, 8, 16)
GRID = (41, 41)


def counted(state: HalfRod, hard: float, twisting: float) -> tuple[int, int, int, int]:
    """Unstable modes in the plane (even, odd) and out of it (even, odd)."""
    section = replace(state.parameters, bending_2=hard, twisting=twisting)
    modes = planar_modes(state.with_parameters(section), CORE)
    return modes.in_even, modes.in_odd, modes.out_even, modes.out_odd


def main() -> None:
    """Count, print the rectangles, draw."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("-o", default=Path("docs/images/strip-map.png"), type=Path)
    out = parser.parse_args().o
    import matplotlib as mpl

    mpl.use("Agg")
    import matplotlib.pyplot as plt
    from matplotlib.colors import ListedColormap

    path = Catalogue(replace(ROD, bending_2=16.0, director=SIDEWAYS)).pt()
    hard = np.geomspace(1.0001, 300, GRID[0])
    twisting = np.linspace(0.2, 3.0, GRID[1])
    figure, panels = plt.subplots(
        1, len(DELTAS), figsize=(11, 4), sharey=True, layout="constrained"
    )
    for panel, delta in zip(panels, DELTAS, strict=True):
        state = max(path.landings(delta * math.pi), key=lambda s: s.end_tension)
        for _ in range(HALVINGS):
            state = halved(state)
        counts = np.array([[counted(state, h, t) for h in hard] for t in twisting])
        outside = counts[..., 2] + counts[..., 3]
        colors = ListedColormap(["#d9ead3", "#fce5cd", "#f4b183", "#e06666"])
        drawn = panel.pcolormesh(hard, twisting, outside, cmap=colors, vmin=-0.5, vmax=3.5,
                                 shading="nearest", rasterized=True)  # fmt: skip
        x = [max(a * a, 1.0) for a in ASPECTS]
        y = [torsion(a) for a in ASPECTS]
        panel.plot(x, y, "k.-", lw=1, label="rectangles, w/h")
        for a, u, v in zip(ASPECTS, x, y, strict=True):
            panel.annotate(
                f"{a:g}", (u, v), xytext=(3, -11), textcoords="offset points", fontsize=8
            )
            modes = counted(state, max(u, 1.0001), v)
            print(f"delta = {delta:g} pi, w/h = {a:4g}, K2/K1 = {u:6.2f}, K3/K1 = {v:.4f}: modes in plane "
                  f"{modes[0]} + {modes[1]}, out of it {modes[2]} + {modes[3]}")  # fmt: skip
        inside = counts[0, 0, :2]
        panel.set(xscale="log", xlim=(1, 300), xlabel="$K_2/K_1$")
        panel.set_title(rf"$\delta = {delta:g}\,\pi$, in plane: {inside[0]} even, {inside[1]} odd")
    panels[0].set_ylabel("$K_3/K_1$")
    panels[0].legend(loc="lower right", fontsize=8)
    bar = figure.colorbar(drawn, ax=panels, ticks=range(4))
    bar.set_label("unstable modes of Pt out of its plane")
    figure.savefig(out, dpi=130)


if __name__ == "__main__":
    main()
