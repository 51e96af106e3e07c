"""The two tables of a sweep: one row a point (``OUTCOMES``), and the rows kept of every push.

Both begin with the number of the point and its values, one column a key, named as in a scene. Rows have the
columns of a run's table except ``wall_time``, which no two machines share, and the state
(``derod.sweeps.states``).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from derod.pushing.rows import ROW
from derod.record.layout import KIND_BYTES, ROW_UNITS
from derod.record.run import BaseRun
from derod.sweeps.sampling import Point
from derod.sweeps.states import Configuration, configuration

MESSAGE_BYTES = 256
TEXT_BYTES = 32
NOT_SHARED = ("wall_time",)
KEPT = tuple(name for name in ROW.names or () if name not in NOT_SHARED)
STATE = [("out_of_plane", "f8"), ("loops", "i4"), ("coils", "f8")]
PUSHED = np.dtype([*((name, ROW[name]) for name in KEPT), *STATE])
"""One row kept of a push."""
UNITS = {**{name: unit for name, unit in ROW_UNITS.items() if name in KEPT}, "out_of_plane": "D"}


def key_columns(keys: Sequence[str], points: Sequence[Point]) -> list[tuple[str, str]]:
    """A column for each key, of the type of its values."""
    return [(key, kind_of({type(point[k]) for point in points})) for k, key in enumerate(keys)]


def kind_of(types: set[type]) -> str:
    """The type of a column whose values have these types."""
    if types <= {bool}:
        return "?"
    if types <= {int}:
        return "i8"
    return "f8" if types <= {int, float} else f"S{TEXT_BYTES}"


def outcome_type(columns: list[tuple[str, str]]) -> np.dtype:
    """One row a point: its values, how its push ended, and where its rows are."""
    return np.dtype(
        [
            ("point", "i8"),
            *columns,
            ("outcome", f"S{KIND_BYTES}"),
            ("message", f"S{MESSAGE_BYTES}"),
            ("first_row", "i8"),
            ("rows", "i8"),
        ]
    )


def row_type(columns: list[tuple[str, str]]) -> np.dtype:
    """One row kept of a push, with its point."""
    return np.dtype([("point", "i8"), *columns, *PUSHED.descr])


def rows_of(run: BaseRun, which: str) -> np.ndarray:
    """The rows of a push that a sweep keeps, (k,) of ``PUSHED``."""
    table = run.table
    if which == "last":
        chosen = np.arange(len(table))[-1:]
    elif which == "landings":
        chosen = np.flatnonzero(table["landing"])
    else:
        chosen = np.arange(len(table))
    kept = np.zeros(len(chosen), PUSHED)
    for name in KEPT:
        kept[name] = table[name][chosen]
    for row, i in zip(kept, chosen, strict=True):
        state = configuration(run.positions(int(i)))
        for name in Configuration._fields:
            row[name] = getattr(state, name)
    return kept


def fill_keys(row: Any, keys: Sequence[str], point: Point) -> None:
    """Write a point's values into its columns, of one row or of many."""
    for key, value in zip(keys, point, strict=True):
        row[key] = value.encode() if isinstance(value, str) else value
