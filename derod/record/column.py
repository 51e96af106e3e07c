"""A dataset that grows record by record, through h5py's low-level calls.

The high-level ones cost 60 to 200 us each, of which a frame would need twenty; a row of the table took
167 us through HDF5's own conversion of types, and takes 6 us without.
"""

from __future__ import annotations

from typing import Any

import h5py
import numpy as np

from derod.files.texts import fixed


class Column:
    """A chunked dataset of shape (T, *shape), T growing, that others may read meanwhile."""

    def __init__(
        self,
        file: h5py.File,
        name: str,
        dtype: Any,
        shape: tuple[int, ...] = (),
        *,
        per_chunk: int,
        unit: str | None = None,
    ) -> None:
        self.dataset = file.create_dataset(
            name,
            shape=(0, *shape),
            maxshape=(None, *shape),
            chunks=(per_chunk, *shape),
            dtype=dtype,
        )
        if unit is not None:
            self.dataset.attrs["unit"] = fixed(unit)
        self._shape = shape
        self._per_chunk = per_chunk
        self._chunk = np.zeros((per_chunk, *shape), dtype)
        self._ahead = (0,) * len(shape)

    def write(self, i: int, value: Any) -> None:
        """Write record ``i``, the last one or the next.

        Its chunk is written whole, past HDF5's conversion of types, which costs 0.1 ms a row of the table:
        records before it in the chunk are written again as they are, those after it are zero.
        """
        identifier = self.dataset.id
        place = i % self._per_chunk
        if place == 0:
            self._chunk[:] = 0
        self._chunk[place] = value
        identifier.set_extent((i + 1, *self._shape))
        identifier.write_direct_chunk((i - place, *self._ahead), self._chunk)

    def flush(self) -> None:
        """Hand what was written to the operating system."""
        self.dataset.flush()


class Cell:
    """A few numbers of a file that are written again and again, as one."""

    def __init__(self, file: h5py.File, name: str, dtype: Any, value: Any) -> None:
        self._dtype = np.dtype(dtype)
        self.dataset = file.create_dataset(name, data=np.array(value, self._dtype))
        self._type = h5py.h5t.py_create(self._dtype)

    def write(self, value: Any) -> None:
        """Write the numbers and hand them to the operating system."""
        identifier = self.dataset.id
        identifier.write(h5py.h5s.ALL, h5py.h5s.ALL, np.array(value, self._dtype), self._type)
        self.dataset.flush()
