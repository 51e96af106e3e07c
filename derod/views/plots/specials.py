"""Special points of branches, and events of pushes, as markers.

A pitchfork is a cross: filled where the path that leaves it is in the file, hollow where it was not
followed. Folds are upright strokes, the buckling of the straight rod a square.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from derod.views.plots.reading import event_row
from derod.views.plots.style import Theme

SPECIALS = {
    "pitchfork": ("X", 7.5, "pitchfork"),
    "partner missing": ("X", 6.5, "pitchfork to a path not drawn"),
    "fold": ("|", 9.0, "fold"),
    "buckling": ("s", 5.5, "buckling"),
}
EVENTS = {
    "instability": ("*", 13.0, "kick off an unstable state"),
    "snap": ("v", 8.0, "snap over a fold"),
    "turn": ("<", 7.0, "turning point of the push"),
    "coarse": ("P", 7.0, "warning: mesh too coarse"),
}
"""Marker, size and label of the events drawn. Halvings of an increment are left to ``derod info``."""
SAME = 1e-6  # D and relative: a joint is stored with both of its paths


def special_points(file: Any, paths: Sequence[str] = ()) -> dict[str, list[Any]]:
    """Special points of a branch file by kind, those shared by two paths once.

    A pitchfork whose partner was not followed, or is not among ``paths`` (all if empty), is of the
    kind "partner missing".
    """
    names = list(paths or file.keys())
    found: dict[str, list[Any]] = {}
    for name in names:
        for row in file[name].bifurcations:
            kind = row["kind"].decode()
            if kind == "pitchfork" and row["partner"].decode() not in names:
                kind = "partner missing"
            points = found.setdefault(kind, [])
            if not any(_same(row, other) for other in points):
                points.append(row)
    return found


def _same(a: Any, b: Any) -> bool:
    near = abs(a["end_shortening"] - b["end_shortening"]) < SAME
    return bool(
        near and abs(a["end_tension"] - b["end_tension"]) < SAME * max(1, abs(a["end_tension"]))
    )


def draw_specials(
    axes: Axes, file: Any, theme: Theme, quantity: str, paths: Sequence[str] = ()
) -> None:
    """Bifurcations and folds of the branches that are drawn."""
    for kind, rows in special_points(file, paths).items():
        marker, size, text = SPECIALS.get(kind, ("h", 7.0, kind))
        full = kind == "pitchfork"
        axes.plot(
            [row["end_shortening"] / np.pi for row in rows],
            [row[quantity] for row in rows],
            marker,
            markersize=size,
            color=theme.ink if full or kind == "fold" else theme.paper,
            markeredgecolor=theme.paper if full else theme.ink,
            markeredgewidth=0.8 if full else 1.0,
            linestyle="none",
            label=text,
            gid=f"specials {kind}",
            zorder=8 if full else 6,
        )


def draw_events(axes: Axes, run: Any, theme: Theme, quantity: str) -> None:
    """Kicks, snaps, turning points and warnings of a push, at the increment of each (``event_row``).

    A snap has a thin dotted line from the state before it.
    """
    table = run.table
    for kind, (marker, size, text) in EVENTS.items():
        after = sorted({event_row(run, event) for event in run.events if event.kind == kind})
        if not after:
            continue
        axes.plot(
            table["end_shortening"][after] / np.pi,
            table[quantity][after],
            marker,
            markersize=size,
            markerfacecolor="none",  # a joint may lie beneath
            markeredgecolor=theme.event,
            markeredgewidth=1.4,
            linestyle="none",
            label=text,
            gid=f"event {kind}",
            zorder=10,
        )
        for i in after if kind == "snap" else ():
            rows = table[[max(i - 1, 0), i]]
            axes.plot(
                rows["end_shortening"] / np.pi, rows[quantity], ":", color=theme.event,
                linewidth=1.2, gid="jump", zorder=6,
            )  # fmt: skip
