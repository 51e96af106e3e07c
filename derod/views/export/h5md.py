"""A run as an H5MD file (nongnu.org/h5md, version 1.1), as MDAnalysis' reader opens it.

::

    /particles/trajectory/box                   dimension 3, no boundaries
    /particles/trajectory/position/             step (T), time (T), value (T, N+1, 3): the nodes, D
    /observables/NAME/                          step, time, value (T): a column of the run's table
    /observables/drop_center/                   step, time, value (T, 3), D
    /parameters/scene                           the scene, TOML

The reader makes its atoms of a group called "trajectory". Lengths are in D, which is no unit that it
knows: positions and times carry none, and it is told ``convert_units=False``. ``time`` is what drives the
push, or the increment where the push turns back; ``step`` is the increment.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import h5py
import numpy as np

import derod
from derod.files.outputs import replacing
from derod.record.layout import H5MD_VERSION, ROW_UNITS
from derod.scene import dump_scene
from derod.views.export.series import times

GROUP = "particles/trajectory"
AUTHOR = "derod"  # H5MD wants a name; a run does not know whose it is


def write_h5md(run: Any, path: Path, force: bool) -> list[Path]:
    """Write the run as ``path``. Returns the files."""
    with replacing(path, force=force) as passing, h5py.File(passing, "w") as file:
        _write_head(file, run)
        step, time = np.arange(len(run)), np.array(times(run))
        box = file.create_group(f"{GROUP}/box")
        box.attrs["dimension"], box.attrs["boundary"] = 3, ["none"] * 3
        nodes = _element(file, f"{GROUP}/position", step, time, (run.scene.mesh.edges + 1, 3))
        for i in range(len(run)):
            nodes[i] = run.positions(i)
        for name in run.table.dtype.names:
            column = run.table[name]
            if column.dtype.kind == "b":
                column = column.astype("u1")  # every reader has small numbers, not all have flags
            _element(file, f"observables/{name}", step, time, (), column.dtype)[...] = column
            if name in ROW_UNITS:
                file[f"observables/{name}/value"].attrs["unit"] = ROW_UNITS[name]
        if run.scene.drop is not None:
            center = _element(file, "observables/drop_center", step, time, (3,))
            center[...] = [run.drop_center(i) for i in range(len(run))]
            center.attrs["unit"] = "D"
    return [path]


def _write_head(file: h5py.File, run: Any) -> None:
    head = file.create_group("h5md")
    head.attrs["version"] = np.array(H5MD_VERSION, "i4")
    head.create_group("author").attrs["name"] = AUTHOR
    creator = head.create_group("creator")
    creator.attrs["name"], creator.attrs["version"] = "derod", derod.__version__
    file["parameters/scene"] = dump_scene(run.scene)
    file["parameters"].attrs["length"] = "D, the drop's diameter"
    file["parameters"].attrs["force"] = "K0 D-2"
    file["parameters"].attrs["energy"] = "K0 D-1"


def _element(
    file: h5py.File,
    name: str,
    step: np.ndarray,
    time: np.ndarray,
    shape: tuple[int, ...],
    dtype: Any = "f8",
) -> h5py.Dataset:
    """A time-dependent element; returns its value, (T, ...), to be filled."""
    group = file.create_group(name)
    group["step"], group["time"] = step, time
    return group.create_dataset("value", (len(step), *shape), dtype)
