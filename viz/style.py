"""One look for all figures: a light and a dark style, colours that colour-blind eyes tell apart."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import matplotlib as mpl

mpl.use("Agg")

import matplotlib.pyplot as plt
from matplotlib.figure import Figure

from derod.cli import carry_out
from derod.outputs import check_output, replacing
from derod.terminal import say_done


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
)  # fmt: skip
THEMES = {theme.name: theme for theme in (LIGHT, DARK)}

LABELS = {
    "delta": r"end-shortening  $\delta/\pi$",
    "end_tension": r"tension  $t$   ($K_0/D^2$)",
    "energy_hat": r"energy  $\hat{E}$   ($K_0/D$)",
    "s": r"arc length from the middle  $s$   ($D$)",
    "curvature": r"curvature  $\kappa$   ($1/D$)",
    "edge_tension": r"tension  $\mathbf{n}\cdot\mathbf{d}_3$   ($K_0/D^2$)",
}


def use(theme: Theme) -> None:
    """Make ``theme`` the style of the figures that follow."""
    mpl.rcParams.update(
        {
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
    )


def path_color(theme: Theme, name: str) -> str:
    """The colour of a branch: paths of a family share theirs ("3D-L2" is "3D", "L4" is "L2")."""
    if name in theme.paths:
        return theme.paths[name]
    if name.startswith("3D"):
        return theme.paths["3D"]
    if name.startswith("L"):
        return theme.paths["L2"]
    return theme.paths["Tri2"]


def new_figure(width: float, height: float) -> Figure:
    """An empty figure of that many inches."""
    return plt.figure(figsize=(width, height), layout="constrained")


def add_output(parser: argparse.ArgumentParser) -> None:
    """The options that every figure has."""
    parser.add_argument(
        "-o", "--output", nargs="+", required=True, metavar="OUT", help="OUT.pdf, OUT.png, ..."
    )
    parser.add_argument("--force", action="store_true", help="replace OUT if it exists")
    parser.add_argument("--style", choices=sorted(THEMES), default="light")
    parser.add_argument("--dpi", type=int, default=160, help="of pixel pictures")


def parsed(parser: argparse.ArgumentParser, arguments: Sequence[str] | None) -> argparse.Namespace:
    """The arguments; outputs that must not be written are refused before any work."""
    args = parser.parse_args(arguments)
    inputs = getattr(args, "files", None) or [getattr(args, "file", None)]
    outputs = args.output if isinstance(args.output, list) else [args.output]
    for i, output in enumerate(outputs):
        check_output(output, force=args.force, inputs=inputs, others=outputs[:i])
    return args


def save(
    figure: Figure, outputs: Sequence[str | Path], dpi: int = 160, force: bool = False
) -> None:
    """Write a figure, vector or pixels by the name's ending, and let go of it."""
    for output in outputs:
        path = Path(output)
        undated = {"CreationDate": None} if path.suffix == ".pdf" else None
        with replacing(path, force=force) as passing:
            kind = path.suffix.removeprefix(".") or "png"
            figure.savefig(passing, dpi=dpi, metadata=undated, format=kind)
        say_done(str(path))
    plt.close(figure)


def started(main: Callable[[], int]) -> int:
    """Do what a script's ``main`` does; what goes wrong is one line and an exit code."""
    return carry_out(main)
