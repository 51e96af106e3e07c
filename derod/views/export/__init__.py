"""Runs and branches for other programs: CSV tables, VTK files for ParaView, H5MD trajectories.

::

    from derod.views.export import export

    export(run, "coil.csv")
    export(run, "vtk/coil.pvd")
    export(run, "coil.h5md")
    export(branches, "branches.csv")
"""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

from derod.exits import UsageError
from derod.views.export.output import check_target, write_file

ENDINGS = ("csv", "pvd", "h5md")


def export(file: Any, output: str | os.PathLike[str], *, force: bool = False) -> list[Path]:
    """Write an open run, branch file or sweep as ``output``: .csv, or (runs) .pvd, .h5md.

    Returns the files written. What is there is only replaced with ``force``. Raises UsageError.
    """
    path = Path(output)
    is_branches, is_sweep = hasattr(file, "parameters"), hasattr(file, "outcomes")
    check_target(path, force, ENDINGS)
    if is_branches and path.suffix.lower() != ".csv":
        raise UsageError(
            f"{file.path}: is a branch file; allowed for {path}: a run file (derod push)"
        )
    if is_sweep and path.suffix.lower() != ".csv":
        raise UsageError(f"{file.path}: is a sweep; allowed for {path}: a run file (derod push)")
    if path.suffix.lower() == ".csv":
        from derod.views.export.table import branches_text, run_text, sweep_text

        write = branches_text if is_branches else sweep_text if is_sweep else run_text
        text = write(file)
        write_file(path, text.encode("utf-8"), force)
        return [path]
    if not len(file):
        raise UsageError(f"{file.path or 'a run in memory'}: has no increment to export")
    if path.suffix.lower() == ".h5md":
        from derod.views.export.h5md import write_h5md

        return write_h5md(file, path, force)
    from derod.views.export.series import write_series

    return write_series(file, path, force)
