"""Runs as they look at a prompt and in a notebook: a line; a small table and a picture."""

from __future__ import annotations

from base64 import b64encode
from html import escape
from typing import TYPE_CHECKING, Any

import numpy as np

from derod.errors import DerodError
from derod.record.ending import ending_words
from derod.scene.axis import END_SHORTENING, axes_of
from derod.scene.html import html_table

if TYPE_CHECKING:
    from derod.record.run import BaseRun

PICTURE = 560  # pixels wide
MOST_ROWS = 12


def picture_html(file: Any) -> str:
    """The file's picture, or in words why there is none."""
    try:
        data = b64encode(file.plot()._repr_png_()).decode()
    except (DerodError, OSError) as error:
        return f"<p>no picture: {escape(str(error))}</p>"
    return f"<img alt='t and E_hat' width='{PICTURE}' src='data:image/png;base64,{data}'/>"


def run_text(run: BaseRun) -> str:
    """A line: which run, how many increments, how it ended."""
    name = run.path or "in memory"
    try:
        _ = run.scene
    except DerodError as error:
        return f"<run {name}: {error}>"
    state = "running, or killed" if run.ending is None else ending_words(run.ending)
    return f"<run {name}: {len(run)} increments, {state}>"


def run_html(run: BaseRun) -> str:
    """The landings as a table, and t and E_hat as a picture."""
    title = run_text(run)[1:-1]
    if not len(run):
        return html_table(title, (), ())
    axis, table = END_SHORTENING, run.table
    others = [one for one in axes_of(run.scene) if one.column not in (axis.column, "end_tension")]
    wanted = np.array(table["landing"])
    wanted[-1] = True
    chosen = np.flatnonzero(wanted)
    chosen = chosen[np.unique(np.linspace(0, len(chosen) - 1, MOST_ROWS).round().astype(int))]
    rows = [
        (row["increment"], axis.both(float(row[axis.column])),
         *(f"{row[one.column]:.6g}" for one in others), f"{row['end_tension']:.6g}",
         f"{row['energy_hat']:.6g}", f"{row['wetted_length']:.6g}", row["unstable_modes"])
        for row in table[chosen]
    ]  # fmt: skip
    more = [f"{one.name} ({one.unit})" for one in others]
    head = (
        "increment",
        axis.name,
        *more,
        "t (K0/D^2)",
        "E_hat (K0/D)",
        "wetted (D)",
        "unstable modes",
    )
    events = [(event.kind, axis.both(event.end_shortening)) for event in run.events]
    told = [one for one in events if one[0] not in ("halving", "turn")]
    happened = html_table("events", ("kind", axis.name), told[:MOST_ROWS]) if told else ""
    return html_table(title, head, rows) + happened + picture_html(run)
