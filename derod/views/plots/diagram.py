"""A diagram: t and E_hat against the control along all paths, stable parts bold, special points marked."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from derod.scene.axis import AXES
from derod.views.plots.style import Theme

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from derod.diagram.content import Diagram, StoredPath

HUES = {
    "planar, flip-even": "Ax",
    "spatial, flip-even": "3D",
    "planar, point-symmetric": "Pt",
    "spatial, point-symmetric": "Tri1",
    "planar, asymmetric": "Tri2",
    "spatial, asymmetric": "L2",
}
"""The colour of a path by the symmetries of its states, named by the paths of ``Theme``."""
MARKS = {"fold": ("D", 12), "branch point": ("o", 16), "joint": ("s", 12)}


def draw(figure: Figure, diagram: Diagram, theme: Theme) -> None:
    """Fill a figure: t above, E_hat below."""
    axis = AXES[diagram.control]
    scale = math.pi if axis.in_pi else 1.0
    upper, lower = figure.subplots(2, 1, sharex=True)
    for axes, column, name in (
        (upper, "end_tension", r"end tension $t$, $K_0/D^2$"),
        (lower, "energy_hat", r"$\hat E$, $K_0/D$"),
    ):
        named: set[str] = set()
        for path in diagram.paths.values():
            color = theme.paths[HUES.get(path.character, "run")]
            label = "" if path.character in named else path.character
            named.add(path.character)
            draw_path(axes, path, diagram.control, column, scale, color, label)
        modes = np.concatenate([one.table["unstable_modes"] for one in diagram.paths.values()])
        values = np.concatenate([path.table[column] for path in diagram.paths.values()])
        shown = values[modes == 0] if np.any(modes == 0) else values
        low, high = np.percentile(values, [1, 99])
        low, high = min(low, shown.min()), max(high, shown.max())
        axes.set_ylim(low - 0.06 * (high - low), high + 0.06 * (high - low))
        axes.set_ylabel(name)
    unit = r"$\pi D$" if axis.in_pi else axis.unit
    words = r"$\delta$" if axis.column == "end_shortening" else axis.name
    lower.set_xlabel(f"{words}, {unit}")
    upper.legend(
        fontsize="small", ncols=3, loc="lower center", bbox_to_anchor=(0.5, 1.0), frameon=False
    )


def draw_path(
    axes: Any, path: StoredPath, control: str, column: str, scale: float, color: str, label: str
) -> None:
    """Draw one path: a thin line, bold where it is stable, and its special points."""
    x, y = path.table[control] / scale, path.table[column]
    axes.plot(x, y, color=color, lw=0.7, alpha=0.8, label=label or None)
    stable = np.where(path.table["unstable_modes"] == 0, y, np.nan)
    axes.plot(x, stable, color=color, lw=2.6, solid_capstyle="round")
    for kind, (mark, size) in MARKS.items():
        rows = path.specials[path.specials["kind"] == kind.encode()]
        axes.scatter(
            rows["value"] / scale, rows[column], s=size, marker=mark, zorder=3,
            facecolor=axes.get_facecolor(), edgecolor=color, linewidth=0.9,
        )  # fmt: skip
