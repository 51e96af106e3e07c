"""The rows of a run's table: the listed columns, and those of every control and part of the energy."""

from __future__ import annotations

import numpy as np

from derod.equilibrium.energies import PARTS
from derod.pushing.columns import COLUMNS, Column, control_column, energy_column
from derod.pushing.controls import CONTROLS


def completed(columns: list[Column]) -> tuple[Column, ...]:
    """Return the columns, with those of controls and energies that are not among them yet."""
    names = {column.name for column in columns}
    more = [energy_column(part) for part in PARTS]
    more += [control_column(control) for control in CONTROLS.values()]
    return (*columns, *(column for column in more if column.name not in names))


ALL = completed(COLUMNS)
ROW = np.dtype([(column.name, column.kind) for column in ALL])
"""One row of the run table."""
