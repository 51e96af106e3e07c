"""What was computed from a run on demand, kept in a file of its own: modes and sensitivities.

::

    /                 attributes: answers ("modes" or "sensitivities"), run, scene (its text), derod
    /increment_0040   a group for each increment asked for; attributes: increment, the row's numbers
        eigenvalue, shape, ...   one dataset a field of ``Modes`` or ``Sensitivities``, attribute unit

The run file stays as it is. Lengths in D, forces in K0/D^2; a derivative's unit is the quantity's over the
parameter's.
"""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import fields
from typing import TYPE_CHECKING, Any

import h5py
import numpy as np

from derod import __version__
from derod.files.outputs import replacing
from derod.pushing.rows import ROW
from derod.record.modes import Modes
from derod.record.sensitivities import Sensitivities

if TYPE_CHECKING:
    from derod.record.kicked import Kicked
    from derod.record.run import BaseRun

UNITS = {
    "modes": {"eigenvalues": "K0 D-4", "sliding_stiffness": "K0 D-3"},
    "sensitivities": {
        "eigenvalue": "K0 D-4", "end_tension": "K0 D-2", "energy_hat": "K0 D-1", "end_shortening": "D",
        "twisting_moment": "K0 D-1", "menisci": "D", "forces": "K0 D-2", "drop": "D", "positions": "D",
        "arc_length": "D", "edge_tension": "K0 D-2",
    },
}  # fmt: skip
"""Of what is derived; a mode's displacements have none, their largest is 1."""


def write_answers(
    path: str | os.PathLike[str],
    run: BaseRun,
    answers: Mapping[int, Modes | Sensitivities],
    kicks: Mapping[int, Kicked] | None = None,
    *,
    force: bool = False,
) -> None:
    """Write modes or sensitivities of increments of a run, and the states it was kicked into.

    Raises ``derod.files.outputs.OutputError``.
    """
    kind = "modes" if isinstance(next(iter(answers.values())), Modes) else "sensitivities"
    with replacing(path, force=force) as passing, h5py.File(passing, "w") as file:
        file.attrs.update(
            answers=kind, run=str(run.path or ""), scene=run.scene.text, derod=__version__
        )
        for i, answer in answers.items():
            group = file.create_group(f"increment_{i:04d}")
            write_row(group, run.table[i])
            for field in fields(answer):
                write_value(group, field.name, getattr(answer, field.name), kind)
            if kicks and i in kicks:
                write_kick(group.create_group("kicked"), kicks[i])


def write_row(group: h5py.Group, row: np.void) -> None:
    """Keep the numbers of a row as attributes."""
    for name in ROW.names or ():
        group.attrs[name] = row[name]


def write_value(group: h5py.Group, name: str, value: Any, kind: str) -> None:
    """Keep one field: words as text, numbers as arrays with their unit."""
    if isinstance(value, tuple):
        group.create_dataset(name, data=np.array(value, dtype=object), dtype=h5py.string_dtype())
        return
    data = group.create_dataset(name, data=value)
    unit = UNITS[kind].get(name, "")
    if unit:
        per = kind == "sensitivities" and name != "eigenvalue"
        data.attrs["unit"] = f"{unit} per unit of the parameter" if per else unit


def write_kick(group: h5py.Group, kick: Kicked) -> None:
    """Keep where a kick led."""
    write_row(group, kick.frame.row)
    for name in (
        "outcome",
        "message",
        "amplitude",
        "energy_before",
        "energy_kicked",
        "energy_after",
        "moved",
    ):
        value = getattr(kick, name)
        group.attrs[name] = str(value) if isinstance(value, str) else value
    for name in ("positions", "arc_length", "drop_center", "edge_tension"):
        group.create_dataset(name, data=getattr(kick.frame, name))
