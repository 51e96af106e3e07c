"""One measurement of a work-precision study: who computed what, at which cost, how well."""

from __future__ import annotations

import csv
import math
from collections.abc import Iterable
from pathlib import Path
from typing import NamedTuple

NAN = float("nan")


class Row(NamedTuple):
    """A whole computation, from the scene to the last state; kernels compiled before.

    Errors are the worst along the path, against ``derod.branches`` or a closed form. What a code does
    not give stays nan.
    """

    problem: str  # "paper-text", "paper-figures", "elastica", "paper-text to 0.5 pi"
    code: str  # "derod", "derod, extrapolated", "PyElastica"
    method: str  # "implicit", "fire", "kinetic", "damped dynamics"
    edges: int
    grading: str  # of the mesh: "default", "uniform", or what was changed
    wall: float  # s, best of the repeats
    cpu: float  # s, of the same repeat
    increments: int = 0
    iterations: int = 0  # Newton iterations or time steps, all together
    tension_error: float = NAN  # relative
    energy_error: float = NAN  # relative, of E_hat
    shape_error: float = NAN  # D
    memory: float = NAN  # peak resident set of the process, MB
    note: str = ""


def larger_error(tension_error: float, energy_error: float) -> float:
    """Return the larger of the errors of t and E_hat, of those that are known."""
    return max(error for error in (tension_error, energy_error) if not math.isnan(error))


def write_csv(path: Path, rows: Iterable[Row]) -> None:
    """Write rows, the field names first."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with path.open("w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(Row._fields)
        writer.writerows(rows)
