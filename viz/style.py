"""The package's style, and what the scripts of this folder share: options and files."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Sequence
from pathlib import Path

import matplotlib as mpl

mpl.use("Agg")

import matplotlib.pyplot as plt
from matplotlib.figure import Figure

from derod.cli import carry_out
from derod.files.outputs import check_output, replacing
from derod.terminal import say_done
from derod.views.plots.style import LABELS, THEMES, Theme, look, path_color

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
