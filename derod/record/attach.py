"""Add a table to a run file that has ended, in one step."""

from __future__ import annotations

import os
import shutil
from pathlib import Path

import h5py
import numpy as np

from derod.errors import RecordError
from derod.record import layout


def attach_extrapolated(path: str | os.PathLike[str], table: np.ndarray) -> None:
    """Put the extrapolated rows into the run file: a copy with them takes its place.

    Raises RecordError; the file is then as it was.
    """
    target = Path(path)
    passing = target.with_name(f".{target.name}.{os.getpid()}.part")
    try:
        shutil.copyfile(target, passing)
        with h5py.File(passing, "r+") as file:
            if layout.EXTRAPOLATED in file:
                del file[layout.EXTRAPOLATED]
            file.create_dataset(layout.EXTRAPOLATED, data=table)
        passing.replace(target)
    except OSError as error:
        passing.unlink(missing_ok=True)
        raise RecordError(f"{target}: the extrapolated rows cannot be added: {error}") from error
