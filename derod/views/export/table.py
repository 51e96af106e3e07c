"""Tables as CSV: a header that names units, numbers that read back exactly."""

from __future__ import annotations

import csv
from collections.abc import Iterable
from io import StringIO
from typing import Any

import numpy as np

from derod.record.layout import ROW_UNITS

POINT_UNITS = {**ROW_UNITS, "meniscus_force": "K0 D-2", "drop_y": "D", "error": "1"}
LEFT_OUT = ("scalars",)  # of a branch's table: what its solver restarts from


def run_text(run: Any) -> str:
    """The rows of a run, one line an increment, columns as in ``frames.ROW``."""
    names = run.table.dtype.names
    header = [titled(name, ROW_UNITS) for name in names]
    return written(header, ([plain(row[name]) for name in names] for row in run.table))


def branches_text(file: Any) -> str:
    """The points of all branches, one after another: name, kind of special point, then the columns."""
    names: list[str] = []
    lines = []
    for name, branch in file.items():
        names = names or [n for n in branch.table.dtype.names if n not in LEFT_OUT]
        kinds = {int(row["index"]): row["kind"].decode() for row in branch.bifurcations}
        for i, row in enumerate(branch.table):
            lines.append([name, kinds.get(i, ""), *(plain(row[n]) for n in names)])
    return written(["branch", "special", *(titled(n, POINT_UNITS) for n in names)], lines)


def sweep_text(sweep: Any) -> str:
    """The rows of a sweep, one line each: its point, its keys, its columns, its outcome."""
    names = sweep.rows.dtype.names
    outcome = [told.decode() for told in sweep.outcomes["outcome"]]
    header = [*(titled(name, ROW_UNITS | {"out_of_plane": "D"}) for name in names), "outcome"]
    return written(
        header,
        ([*(plain(row[name]) for name in names), outcome[row["point"]]] for row in sweep.rows),
    )


def titled(name: str, units: dict[str, str]) -> str:
    """A column's title, with its unit: "end_tension [K0 D-2]"; counts and flags have none."""
    return f"{name} [{units[name]}]" if name in units else name


def plain(value: Any) -> str:
    """A number as text that reads back as the same number; flags are 0 and 1."""
    if isinstance(value, bytes):
        return value.decode("utf-8", "replace")
    if isinstance(value, np.bool_):
        return str(int(value))
    return repr(value.item())


def written(header: list[str], lines: Iterable[list[str]]) -> str:
    """Header and lines as CSV."""
    buffer = StringIO()
    writer = csv.writer(buffer, lineterminator="\n")
    writer.writerow(header)
    writer.writerows(lines)
    return buffer.getvalue()
