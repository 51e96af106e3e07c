"""The package's style, and what the scripts of this folder share: options and files."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path

import matplotlib as mpl

mpl.use("Agg")

import matplotlib.pyplot as plt
from matplotlib.figure import Figure

from derod.plots.style import LABELS, THEMES, Theme, look, path_color

__all__ = ["LABELS", "THEMES", "Theme", "add_output", "new_figure", "path_color", "save", "use"]


def use(theme: Theme) -> None:
    """Make ``theme`` the style of the figures that follow."""
    mpl.rcParams.update(look(theme))


def new_figure(width: float, height: float) -> Figure:
    """An empty figure of that many inches."""
    return plt.figure(figsize=(width, height), layout="constrained")


def add_output(parser: argparse.ArgumentParser) -> None:
    """The options that every figure has."""
    parser.add_argument(
        "-o", "--output", nargs="+", required=True, metavar="OUT", help="OUT.pdf, OUT.png, ..."
    )
    parser.add_argument("--style", choices=sorted(THEMES), default="light")
    parser.add_argument("--dpi", type=int, default=160, help="of pixel pictures")


def save(figure: Figure, outputs: Sequence[str | Path], dpi: int = 160) -> None:
    """Write a figure, vector or pixels by the name's ending, and let go of it."""
    for output in outputs:
        path = Path(output)
        path.parent.mkdir(parents=True, exist_ok=True)
        undated = {"CreationDate": None} if path.suffix == ".pdf" else None
        figure.savefig(path, dpi=dpi, metadata=undated)
        print(path)
    plt.close(figure)
