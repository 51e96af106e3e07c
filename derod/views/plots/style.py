"""One look for all figures: a light and a dark style, colours that colour-blind eyes tell apart.

Nothing here imports matplotlib: a style is data, and ``look`` gives it as matplotlib's settings.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True)
class Theme:
    """Colours of a style; paths have the same hue in both (Okabe and Ito's palette)."""

    name: str
    paper: str
    ink: str
    faint: str
    water: tuple[float, float, float]
    rim: str
    glow: float  # how white the drop is where the light falls on it
    paths: dict[str, str]
    parts: tuple[str, ...]
    sequential: str
    diverging: str
    event: str = "#d6006d"  # kicks and snaps of a push


LIGHT = Theme(
    name="light",
    paper="#ffffff",
    ink="#1b1e23",
    faint="#c9ccd3",
    water=(0.44, 0.67, 0.88),
    rim="#4a7fb0",
    glow=0.62,
    paths={
        "Ax": "#0072b2", "3D": "#d55e00", "L2": "#009e73", "Pt": "#8a5a9e",
        "Tri1": "#b8860b", "Tri2": "#7f7f7f", "run": "#1b1e23",
    },
    parts=("#e69f00", "#009e73", "#cc79a7", "#56b4e9"),
    sequential="viridis",
    diverging="RdBu_r",
)  # fmt: skip
DARK = Theme(
    name="dark",
    paper="#12141a",
    ink="#e9ebf0",
    faint="#3a3f4b",
    water=(0.36, 0.58, 0.85),
    rim="#7fb2e5",
    glow=0.22,
    paths={
        "Ax": "#56b4e9", "3D": "#ff8c42", "L2": "#2fd6a6", "Pt": "#cf9be6",
        "Tri1": "#f0e442", "Tri2": "#a8adb8", "run": "#ffffff",
    },
    parts=("#e69f00", "#2fd6a6", "#cc79a7", "#56b4e9"),
    sequential="viridis",
    diverging="RdBu_r",
    event="#ff5fb0",
)  # fmt: skip
THEMES = {theme.name: theme for theme in (LIGHT, DARK)}

LABELS = {
    "delta": r"end-shortening  $\delta/\pi$   ($D$)",
    "end_tension": r"tension  $t$   ($K_0/D^2$)",
    "energy_hat": r"energy  $\hat{E}$   ($K_0/D$)",
    "increment": "increment  (the push turns back)",
    "energy": r"energy  $E$   ($K_0/D$)",
    "eigenvalue": r"lowest eigenvalues  $\lambda$   ($K_0/D^4$)",
    "s": r"arc length from the middle  $s$   ($D$)",
    "curvature": r"curvature  $\kappa$   ($1/D$)",
    "edge_tension": r"tension  $\mathbf{n}\cdot\mathbf{d}_3$   ($K_0/D^2$)",
}


def look(theme: Theme) -> Any:  # a dict; its keys' type is matplotlib's own
    """``theme`` as matplotlib's settings, for ``matplotlib.rc_context``."""
    return {
        "font.family": "STIXGeneral",
        "mathtext.fontset": "stix",
        "font.size": 11,
        "axes.labelsize": 12,
        "axes.titlesize": 12,
        "axes.linewidth": 0.8,
        "axes.spines.top": False,
        "axes.spines.right": False,
        "axes.edgecolor": theme.ink,
        "axes.labelcolor": theme.ink,
        "axes.titlecolor": theme.ink,
        "axes.facecolor": theme.paper,
        "figure.facecolor": theme.paper,
        "savefig.facecolor": theme.paper,
        "text.color": theme.ink,
        "xtick.color": theme.ink,
        "ytick.color": theme.ink,
        "xtick.direction": "in",
        "ytick.direction": "in",
        "legend.frameon": False,
        "lines.solid_capstyle": "round",
        "lines.dash_capstyle": "butt",
        "pdf.fonttype": 42,
        "svg.fonttype": "none",
        "figure.max_open_warning": 0,
    }


def path_color(theme: Theme, name: str) -> str:
    """The colour of a branch: paths of a family share theirs ("3D-L2" is "3D", "L4" is "L2")."""
    if name in theme.paths:
        return theme.paths[name]
    if name.startswith("3D"):
        return theme.paths["3D"]
    if name.startswith("L"):
        return theme.paths["L2"]
    return theme.paths["Tri2"]
