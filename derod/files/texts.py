"""Texts as attributes of HDF5 files: of fixed length, inside the object that has them.

Texts of variable length, h5py's own choice, lie in HDF5's global heap: a flipped bit in one of its free
spaces sends the library into an endless loop.
"""

from __future__ import annotations

import numpy as np


def fixed(text: str) -> np.bytes_:
    """The text in UTF-8, as an attribute of just its length."""
    return np.bytes_(text.encode("utf-8", "replace"))
