"""The parts of E_hat along a push, stacked: ``python viz/energies.py RUN.h5 -o OUT.pdf``."""

from __future__ import annotations

import argparse
import sys
from typing import Any

from matplotlib.figure import Figure
from style import THEMES, Theme, add_output, new_figure, parsed, save, started, use

from derod.views.plots import energies
from derod.views.plots.kinds import Options
from derod.views.plots.reading import open_files


def figure(run: Any, theme: Theme) -> Figure:
    """The package's picture in this folder's style."""
    use(theme)
    made = new_figure(1, 1)  # the drawing sets the size
    energies.draw(made, [run], [], theme, Options())
    return made


def main(arguments: list[str] | None = None) -> int:
    """Draw the energies of a run."""
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
