"""Measured forces against displacements: a CSV table whose header names columns and units.

::

    displacement [mm], force [uN], error [uN]
    0.12, 8.31, 0.05
    0.15, ,                                    a gap: left out
    # a remark

Columns: ``displacement`` or ``end_shortening`` (units D, m, mm, um, nm, cm), ``force`` or ``end_tension``
(K0/D^2 or K0 D-2, N, mN, uN, nN), and perhaps ``error``, the standard uncertainty of the force in its unit,
or ``weight``, what its residual is multiplied by. A column without a unit is in D and K0/D^2.
"""

from __future__ import annotations

import csv
import math
import os
import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from derod.errors import SceneError
from derod.scene.quantities import read_quantity
from derod.scene.units import DIMENSIONS, SPELLINGS

TITLE = re.compile(r"\s*([^\[(]*?)\s*(?:[\[(]\s*(.*?)\s*[\])])?\s*")
NAMES = {
    "displacement": "displacement",
    "end_shortening": "displacement",
    "delta": "displacement",
    "force": "force",
    "end_tension": "force",
    "tension": "force",
    "t": "force",
    "error": "error",
    "uncertainty": "error",
    "weight": "weight",
}
REDUCED = {"displacement": ("", "D"), "force": ("", "K0/D^2", "K0 D-2")}
SI = {
    "displacement": {name: float(size) for name, size in DIMENSIONS["length"].items()},
    "force": {"N": 1.0, "mN": 1e-3, "uN": 1e-6, "nN": 1e-9},
}
GAPS = ("", "nan", "na", "-")
MOST_BYTES = 2**26
COLUMNS = "displacement, force, and perhaps error or weight, with units such as [mm] and [uN]"


@dataclass(frozen=True, slots=True)
class Data:
    """A measured curve, without its gaps, in the order of its displacements."""

    displacement: np.ndarray
    """(n,), D, or m where ``si``."""
    force: np.ndarray
    """(n,), K0/D^2, or N."""
    weight: np.ndarray
    """(n,), what residuals are multiplied by: 1/error where errors were measured."""
    si: bool
    has_errors: bool
    """Whether weights are 1/error: then the covariance is absolute, else scaled by what is left."""
    gaps: int = 0
    """Rows that were left out: without a number, or not pushed in yet."""
    path: str | None = None

    def __len__(self) -> int:
        return len(self.force)


def read_data(path: str | os.PathLike[str]) -> Data:
    """The measured curve of a CSV file.

    Raises SceneError, which names the file, the line and what is allowed.
    """
    name = os.fsdecode(os.fspath(path))
    try:
        if Path(name).stat().st_size > MOST_BYTES:
            raise ValueError(f"it is longer than {MOST_BYTES} bytes")
        text = Path(name).read_text("utf-8-sig")
        lines = [
            (number, line)
            for number, line in enumerate(text.splitlines(), 1)
            if line.strip() and not line.lstrip().startswith("#")
        ]
        rows = [(number, next(csv.reader([line]))) for number, line in lines]
    except (OSError, ValueError, csv.Error) as error:
        words = getattr(error, "strerror", None) or error
        raise SceneError(f"cannot be read as data: {words}", file=name) from error
    if not rows:
        raise SceneError("is empty", file=name, allowed=f"a header ({COLUMNS}) and rows")
    places, units = _header(rows[0][1], name)
    columns: dict[str, list[float]] = {column: [] for column in places}
    gaps = 0
    for number, cells in rows[1:]:
        values = {c: _cell(cells, place, c, number, name) for c, place in places.items()}
        if any(math.isnan(value) for value in values.values()):
            gaps += 1
            continue
        for column, value in values.items():
            columns[column].append(value)
    return make_data(
        columns["displacement"],
        columns["force"],
        error=columns.get("error"),
        weight=columns.get("weight"),
        units=(units["displacement"], units["force"]),
        gaps=gaps,
        path=name,
    )


def make_data(
    displacement: object,
    force: object,
    *,
    error: object = None,
    weight: object = None,
    units: tuple[str, str] = ("D", "K0/D^2"),
    gaps: int = 0,
    path: str | None = None,
) -> Data:
    """A measured curve from arrays (n,) in ``units``; rows with NaN, or not pushed in, are left out.

    Raises SceneError.
    """
    x, y = np.array(displacement, dtype=float), np.array(force, dtype=float)
    if error is not None and weight is not None:
        raise SceneError("are given both", file=path, key="error, weight", allowed="one of them")
    given = np.ones_like(y) if error is None and weight is None else np.array(
        weight if error is None else error, dtype=float
    )  # fmt: skip
    if not (x.ndim == 1 and x.shape == y.shape == given.shape):
        raise SceneError("have different lengths", file=path, key="displacement, force")
    si = units[0] in SI["displacement"]
    if si != (units[1] in SI["force"]):
        raise SceneError("mixes reduced and SI", file=path, key="units", value=list(units),
                         allowed="D with K0/D^2, or a length with a force")  # fmt: skip
    scale = SI["force"][units[1]] if si else 1.0
    x = x * (SI["displacement"][units[0]] if si else 1.0)
    whole = np.isfinite(x) & np.isfinite(y) & np.isfinite(given) & (x > 0.0)
    bad = whole & ((given <= 0.0) if error is not None else (given < 0.0))
    if bad.any():
        raise SceneError("is out of range", file=path, key="error" if error is not None else "weight",
                         value=float(given[bad][0]), allowed="numbers above 0")  # fmt: skip
    w = given / scale if error is None else 1.0 / (given * scale)
    order = np.argsort(x[whole], kind="stable")
    return Data(
        x[whole][order], (y * scale)[whole][order], w[whole][order], si, error is not None,
        gaps + int(np.count_nonzero(~whole)), path,
    )  # fmt: skip


def _header(titles: list[str], file: str) -> tuple[dict[str, int], dict[str, str]]:
    """Where the columns stand, and in which units."""
    places: dict[str, int] = {}
    units = {"displacement": "", "force": ""}
    for place, title in enumerate(titles):
        found = TITLE.fullmatch(title)
        column = NAMES.get(found[1].lower().replace(" ", "_")) if found else None
        if found is None or column is None:
            continue  # a column of something else
        if column in places:
            raise SceneError("is there twice", file=file, key=column)
        places[column] = place
        unit = found[2] or ""
        for spelling, plain in SPELLINGS.items():
            unit = unit.replace(spelling, plain)
        if column in SI:
            allowed = (*REDUCED[column], *SI[column])
            if unit not in allowed:
                raise SceneError("has an unknown unit", file=file, key=column, value=unit,
                                 allowed=", ".join(name for name in allowed if name))  # fmt: skip
            units[column] = unit
        elif column == "error" and unit and unit != units["force"]:
            raise SceneError("is not in the unit of the force", file=file, key=column, value=unit,
                             allowed=units["force"] or "none")  # fmt: skip
    for column in ("displacement", "force"):
        if column not in places:
            raise SceneError("is missing in the header", file=file, key=column, allowed=COLUMNS)
    return places, units


def _cell(cells: list[str], place: int, column: str, line: int, file: str) -> float:
    text = cells[place].strip() if place < len(cells) else ""
    if text.lower() in GAPS:
        return math.nan
    try:
        return read_quantity(text)
    except ValueError as error:
        raise SceneError(str(error), file=file, key=f"line {line}: {column}", value=text,
                         allowed="a number, or nothing for a gap") from error  # fmt: skip
