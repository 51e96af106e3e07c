"""Runs as pandas and xarray have tables and fields."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from derod.needs import need
from derod.record import layout
from derod.scene.axis import END_SHORTENING

if TYPE_CHECKING:
    from derod.record.run import BaseRun


def to_pandas(run: BaseRun) -> Any:
    """See ``BaseRun.to_pandas``."""
    pandas = need("pandas", "to_pandas")
    table = pandas.DataFrame({name: run.table[name] for name in run.table.dtype.names or ()})
    table = table.set_index("increment")
    table.attrs["units"] = {name: layout.ROW_UNITS.get(name, "") for name in table.columns}
    return table


def to_xarray(run: BaseRun) -> Any:
    """See ``BaseRun.to_xarray``."""
    xarray = need("xarray", "to_xarray")
    table, axis = run.table, END_SHORTENING
    fields: dict[str, Any] = {
        name: ("increment", table[name], _unit(layout.ROW_UNITS.get(name)))
        for name in table.dtype.names or ()
        if name not in ("increment", axis.column)
    }
    nodes = run.scene.mesh.edges + 1
    arrays = {
        "positions": (("increment", "node", "axis"), (nodes, 3), run.positions, "D"),
        "arc_length": (("increment", "node"), (nodes,), run.arc_length, "D"),
        "curvature": (("increment", "node"), (nodes,), run.curvature, "D-1"),
        "edge_tension": (("increment", "edge"), (nodes - 1,), run.edge_tension, "K0 D-2"),
        "drop_center": (("increment", "axis"), (3,), run.drop_center, "D"),
    }
    for name, (dims, shape, read, unit) in arrays.items():
        values = np.empty((len(table), *shape))
        for i in range(len(table)):
            values[i] = read(i)
        fields[name] = (dims, values, {"units": unit})
    coordinates = {
        "increment": table["increment"],
        axis.column: ("increment", table[axis.column], _unit(layout.ROW_UNITS.get(axis.column))),
        "axis": ["x", "y", "z"],
    }
    return xarray.Dataset(fields, coordinates, attrs={"scene": run.scene.text})


def _unit(unit: str | None) -> dict[str, str]:
    return {} if unit is None else {"units": unit}
