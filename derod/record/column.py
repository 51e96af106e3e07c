"""A dataset that grows record by record, through h5py's low-level calls.

The high-level ones cost 60 to 200 us each, of which a frame would need twenty.
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
        self._dtype = np.dtype(dtype)
        self._shape = shape
        self._whole_chunk = per_chunk == 1
        self._one = h5py.h5s.create_simple((1, *shape))
        self._type = h5py.h5t.py_create(self._dtype)

    def write(self, i: int, value: Any) -> None:
        """Write record ``i``, the last one or the next."""
        identifier = self.dataset.id
        record = np.ascontiguousarray(value, dtype=self._dtype).reshape((1, *self._shape))
        identifier.set_extent((i + 1, *self._shape))
        start = (i,) + (0,) * len(self._shape)
        if self._whole_chunk:
            identifier.write_direct_chunk(start, record)
            return
        space = h5py.h5s.create_simple((i + 1, *self._shape))
        space.select_hyperslab(start, (1, *self._shape))
        identifier.write(self._one, space, record, self._type)

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
