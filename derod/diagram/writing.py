"""A diagram file, made anew and put in the old one's place in one step."""

from __future__ import annotations

from pathlib import Path

import h5py
import numpy as np

from derod.diagram.checking import group_check, head_check
from derod.diagram.content import Diagram, StoredPath
from derod.diagram.layout import FORMAT, FRAMES, SPECIALS, TABLE, TEXTS
from derod.files.outputs import replacing


def write_diagram(path: str | Path, diagram: Diagram, *, overwrite: bool = False) -> None:
    """Write a diagram to ``path``, whole or not at all. Raises OutputError, InUseError."""
    with (
        replacing(path, force=overwrite) as passing,
        h5py.File(passing, "w", libver=("v110", "v110"), locking=False) as file,
    ):
        file.attrs["format"] = FORMAT
        file.attrs["units"] = "lengths D, forces K0/D^2, energies K0/D, angles radians"
        file.attrs["scene"], file.attrs["control"] = diagram.scene_text, diagram.control
        file.attrs["command"] = diagram.command
        file.attrs["stages"] = " ".join(diagram.stages)
        file.attrs["complete"] = np.int8(diagram.complete)
        file.attrs["slides"] = np.int8(diagram.slides)
        groups = file.create_group("paths", track_order=True)
        for one in diagram.paths.values():
            write_path(groups.create_group(one.name), one)
        file.attrs["check"] = np.uint64(head_check(file))


def write_path(group: h5py.Group, one: StoredPath) -> None:
    """Write one path into its group."""
    for name in TEXTS:
        group.attrs[name] = getattr(one, name)
    group.attrs["whole"] = np.int8(one.whole)
    group[TABLE], group[SPECIALS] = one.table, one.specials
    for name in FRAMES:
        group[name] = getattr(one, name)
    group.attrs["check"] = np.uint64(group_check(one.name, group))
