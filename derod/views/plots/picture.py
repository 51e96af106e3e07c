"""Figures of the package: made without a screen, shown in notebooks, written whole."""

from __future__ import annotations

from collections.abc import Callable
from io import BytesIO
from pathlib import Path
from typing import Any

import matplotlib as mpl
from matplotlib.figure import Figure

from derod.exits import UsageError
from derod.views.export.output import write_file
from derod.views.plots.style import Theme, look

NO_WINDOWS = {"agg", "cairo", "pdf", "pgf", "ps", "svg", "template"}


class Picture(Figure):
    """A figure that a notebook shows by itself; everything else is matplotlib's."""

    def _repr_png_(self) -> bytes:
        return rendered(self, "png", 100)


def make_picture(draw: Callable[[Figure], None], theme: Theme, window: bool) -> Picture:
    """A picture drawn by ``draw``; one for a window belongs to pyplot, others to nobody."""
    with mpl.rc_context(look(theme)):
        picture: Any
        if window:
            import matplotlib.pyplot as plt

            if plt.get_backend().lower() in NO_WINDOWS:
                raise UsageError(
                    f"show: matplotlib's {plt.get_backend()} opens no windows (there is no screen, "
                    "or MPLBACKEND says so); leave it out and a file is written"
                )
            picture = plt.figure(FigureClass=Picture, layout="constrained")
        else:
            picture = Picture(layout="constrained")
        draw(picture)
        picture.draw_without_rendering()  # ticks take their look when they are first drawn
    made: Picture = picture
    return made


def show_window(picture: Picture) -> None:
    """Open the window and wait until it is closed."""
    import matplotlib.pyplot as plt

    plt.figure(picture.number)
    plt.show()


def rendered(picture: Figure, ending: str, dpi: int) -> bytes:
    """The picture as the bytes of a file; the same picture gives the same bytes."""
    undated = {"pdf": {"CreationDate": None}, "svg": {"Date": None}}.get(ending)
    buffer = BytesIO()
    with mpl.rc_context({"pdf.fonttype": 42, "svg.fonttype": "none", "svg.hashsalt": "derod"}):
        picture.savefig(
            buffer, format=ending, dpi=dpi, metadata=undated, facecolor=picture.get_facecolor()
        )
    return buffer.getvalue()


def write_picture(picture: Picture, path: Path, theme: Theme, dpi: int, force: bool) -> None:
    """Write the picture, vector or pixels by the name's ending. Raises UsageError."""
    with mpl.rc_context(look(theme)):
        write_file(path, rendered(picture, path.suffix[1:].lower(), dpi), force)
