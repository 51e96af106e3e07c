"""Add a table to a run file that has ended, in one step."""

from __future__ import annotations

import os
import shutil

import h5py
import numpy as np

from derod.errors import RecordError
from derod.files.digest import table_digest
from derod.files.lock import Lock
from derod.files.outputs import passing_name, publish, sweep, words
from derod.record import layout
from derod.record.writer import locked


def attach_extrapolated(path: str | os.PathLike[str], table: np.ndarray) -> None:
    """Put the extrapolated rows into the run file: a copy with them takes its place.

    Raises RecordError, InUseError where another process writes it; the file is then as it was.
    """
    with locked(path) as held:
        target = held.target
        passing = passing_name(target)
        try:
            sweep(target)
            passing.unlink(missing_ok=True)
            with Lock.make(str(passing)):
                shutil.copyfile(target, passing)
                with h5py.File(passing, "r+", libver=layout.LIBVER, locking=False) as file:
                    if layout.EXTRAPOLATED in file:
                        del file[layout.EXTRAPOLATED]
                    stored = file.create_dataset(layout.EXTRAPOLATED, data=table)
                    stored.attrs[layout.CHECK] = np.uint64(table_digest(b"extrapolated", table))
                publish(passing, target, held)
        except (OSError, RuntimeError) as error:
            raise RecordError(
                f"{target}: the extrapolated rows cannot be added: {words(error)}"
            ) from error
        finally:
            passing.unlink(missing_ok=True)
