"""Pictures of runs and branches, by matplotlib: ``derod plot``, ``run.plot``, ``branches.plot``.

::

    run.plot("path", branches, output="coil-path.png")
    run.plot("shapes", at=["0.5 pi", "1 pi"])
    branches.plot("path")

Every kind is a file of this package with a function ``draw(figure, runs, branches, theme, options)``,
named in ``kinds.KINDS``. matplotlib is imported when a picture is made.
"""

from __future__ import annotations

import os
from collections.abc import Sequence
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any

from derod.exits import UsageError
from derod.views.plots.kinds import KINDS, Options, check_files, need_matplotlib, read_places

if TYPE_CHECKING:
    from derod.views.plots.picture import Picture

ENDINGS = ("png", "pdf", "svg")


def plot(
    kind: str,
    files: Sequence[Any],
    *,
    at: Sequence[str | float] | str = (),
    paths: Sequence[str] = (),
    every: int = 1,
    output: str | os.PathLike[str] | None = None,
    force: bool = False,
    show: bool = False,
    style: str = "light",
    dpi: int = 160,
) -> Picture:
    """Draw a picture of open runs and branch files and return it (a matplotlib figure).

    ``at``: end-shortenings, D, such as ``["0.5 pi", 2.0]`` or ``"0.5 pi, 2"``. ``paths``: names of branches,
    all if empty. ``every``: compare every n-th increment. With ``output`` the picture is written; a file
    that is there is only replaced with ``force``. With ``show`` a window is opened. Raises UsageError.
    """
    if kind not in KINDS:
        raise UsageError(f"kind = {kind!r}: allowed: {', '.join(KINDS)}")
    if style not in ("light", "dark"):
        raise UsageError(f"style = {style!r}: allowed: light, dark")
    if every < 1:
        raise UsageError(f"every = {every}: allowed: 1, 2, 3, ...")
    if dpi < 1:
        raise UsageError(f"dpi = {dpi}: allowed: 1 or more")
    target = None if output is None else Path(output)
    if target is not None:
        from derod.views.export.output import check_target

        check_target(target, force, ENDINGS, "output")
    runs = [file for file in files if not hasattr(file, "parameters")]
    branches = [file for file in files if hasattr(file, "parameters")]
    options = Options(read_places(at), tuple(paths), every)
    check_files(kind, runs, branches, options)
    need_matplotlib()
    from derod.views.plots.picture import make_picture, show_window, write_picture
    from derod.views.plots.style import THEMES

    module = import_module(KINDS[kind].module)
    theme = THEMES[style]
    picture = make_picture(
        lambda figure: module.draw(figure, runs, branches, theme, options), theme, show
    )
    if target is not None:
        write_picture(picture, target, theme, dpi, force)
    if show:
        show_window(picture)
    return picture
