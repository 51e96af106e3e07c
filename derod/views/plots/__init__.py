"""Pictures of runs and branches, by matplotlib: ``derod plot``, ``run.plot``, ``branches.plot``.

::

    run.plot("path", branches, output="coil-path.png")
    run.plot("shapes", at=["0.5 pi", "1 pi"])
    branches.plot("path")

Every kind is a file of this package with a function ``draw(figure, runs, branches, theme, options)``,
named in ``kinds.KINDS``. matplotlib is imported when a picture is made.
"""

from __future__ import annotations

from collections.abc import Sequence
from importlib import import_module
from typing import TYPE_CHECKING, Any, Unpack

from derod.exits import UsageError
from derod.views.plots.kinds import KINDS, check_files, need_matplotlib
from derod.views.plots.options import ENDINGS, PlotOptions, read_options

if TYPE_CHECKING:
    from derod.views.plots.picture import Picture

__all__ = ["ENDINGS", "KINDS", "PlotOptions", "plot"]


def plot(kind: str, files: Sequence[Any], **options: Unpack[PlotOptions]) -> Picture:
    """Draw a picture of open runs, sweeps and branch files and return it (a matplotlib figure).

    ``at``: end-shortenings, D, such as ``["0.5 pi", 2.0]`` or ``"0.5 pi, 2"``. ``paths``: names of
    branches, all if empty. ``keys``: the axes of a sweep's picture. ``every``: every n-th increment,
    ``modes``: how many of them, where a kind counts these. With ``output`` the picture is written; a file
    that is there is only replaced with ``force``. With ``show`` a window is opened. ``style``: "light" or
    "dark"; ``dpi``: of pixel pictures. Raises UsageError.
    """
    if kind not in KINDS:
        raise UsageError(f"kind = {kind!r}: allowed: {', '.join(KINDS)}")
    shown, sheet = read_options(options)
    if sheet.output is not None:
        from derod.views.export.output import check_target

        check_target(sheet.output, sheet.force, ENDINGS, "output")
    sweeps = [file for file in files if hasattr(file, "outcomes")]
    runs = [f for f in files if not hasattr(f, "parameters") and not hasattr(f, "outcomes")]
    branches = [file for file in files if hasattr(file, "parameters")]
    check_files(kind, runs, branches, shown, sweeps)
    need_matplotlib()
    from derod.views.plots.picture import make_picture, show_window, write_picture
    from derod.views.plots.style import THEMES

    module = import_module(KINDS[kind].module)
    theme = THEMES[sheet.style]
    picture = make_picture(
        lambda figure: module.draw(figure, runs or sweeps, branches, theme, shown),
        theme,
        sheet.show,
    )
    if sheet.output is not None:
        write_picture(picture, sheet.output, theme, sheet.dpi, sheet.force)
    if sheet.show:
        show_window(picture)
    return picture
