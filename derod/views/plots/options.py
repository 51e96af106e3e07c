"""What ``plot`` may be told by name: what the picture shows, and how and where it is made."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypedDict

from derod.exits import UsageError
from derod.views.plots.kinds import Options, read_places

ENDINGS = ("png", "pdf", "svg")
STYLES = ("light", "dark")


class PlotOptions(TypedDict, total=False):
    """The options of ``plot`` by their names; every one may be left out."""

    at: Sequence[str | float] | str
    """End-shortenings, D, such as ``["0.5 pi", 2.0]`` or ``"0.5 pi, 2"``."""
    paths: Sequence[str]
    """Names of branches, all if empty."""
    keys: Sequence[str]
    """``phase``: two columns of a sweep, its keys where left out."""
    every: int
    """``compare`` and ``eigenvalues``: every n-th increment."""
    modes: int
    """``modes`` and ``eigenvalues``: how many, from the lowest."""
    output: str | os.PathLike[str] | None
    """The file to write: .png, .pdf or .svg."""
    force: bool
    """Replace a file that is there."""
    show: bool
    """Open a window."""
    style: str
    """"light" or "dark"."""
    dpi: int
    """Of pixel pictures."""


@dataclass(frozen=True)
class Sheet:
    """How a picture is made, and where it goes."""

    output: Path | None = None
    force: bool = False
    show: bool = False
    style: str = "light"
    dpi: int = 160


def read_options(given: Mapping[str, Any]) -> tuple[Options, Sheet]:
    """What is shown and how it is made, checked. Raises UsageError; TypeError for names that are none."""
    allowed = sorted(PlotOptions.__annotations__)
    for name in given:
        if name not in allowed:
            raise TypeError(f"plot has no option {name!r}; allowed: {', '.join(allowed)}")
    output = given.get("output")
    shown = Options(
        read_places(given.get("at", ())),
        tuple(given.get("paths", ())),
        given.get("every", Options.every),
        given.get("modes", Options.modes),
        tuple(given.get("keys", ())),
    )
    sheet = Sheet(
        None if output is None else Path(output),
        given.get("force", Sheet.force),
        given.get("show", Sheet.show),
        given.get("style", Sheet.style),
        given.get("dpi", Sheet.dpi),
    )
    if sheet.style not in STYLES:
        raise UsageError(f"style = {sheet.style!r}: allowed: {', '.join(STYLES)}")
    for name, value in (("every", shown.every), ("modes", shown.modes)):
        if value < 1:
            raise UsageError(f"{name} = {value}: allowed: 1, 2, 3, ...")
    if sheet.dpi < 1:
        raise UsageError(f"dpi = {sheet.dpi}: allowed: 1 or more")
    return shown, sheet
