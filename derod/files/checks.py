"""What a foreign HDF5 file must not do to its reader: every part is looked at before it is read.

A part is followed by hard links only, so that no other file is opened. A dataset must keep its values
in the file itself, unfiltered, and within its length: then what is read is never more than what is there.
All functions raise DamageError.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from typing import Any

import h5py
import numpy as np

from derod.errors import RecordError, shown_name
from derod.files.gate import Gate, reason

MOST_CHUNK = 2**26  # bytes; ours are one frame, or 1024 numbers
MOST_ATTRIBUTE = 2**16  # bytes
MOST_ATTRIBUTES = 200
MOST_TEXT = 2**20  # bytes, of a scene
TROUBLE = (AttributeError, IndexError, KeyError, MemoryError, OSError, OverflowError, RuntimeError,
           TypeError, ValueError)  # fmt: skip
"""What h5py and numpy raise at a file that is not what it should be."""


class DamageError(ValueError):
    """A part of a file that is not as derod writes it."""


@contextmanager
def judged(path: str) -> Iterator[None]:
    """Turn whatever h5py and numpy raise at a damaged file into one RecordError."""
    try:
        yield
    except TROUBLE as error:
        words = error.args[0] if isinstance(error, KeyError) and error.args else None
        text = reason(error) if words is None else str(words).splitlines()[0]
        raise RecordError(f"{path}: is damaged: {text}") from error


def part(file: h5py.File, path: str) -> Any:
    """The group or dataset at ``path``, reached by hard links alone."""
    here: Any = file
    for name in path.split("/"):
        if not isinstance(here, h5py.Group):
            raise DamageError(f"{path} is not where it should be")
        link = here.get(name, getlink=True)
        if link is None:
            raise DamageError(f"{path} is missing")
        if not isinstance(link, h5py.HardLink):
            raise DamageError(f"{path} leads elsewhere")
        here = here[name]
    return here


def dataset(file: h5py.File, gate: Gate, path: str) -> h5py.Dataset:
    """The dataset at ``path``, if its values lie in the file and can be no more than the file holds."""
    found = part(file, path)
    if not isinstance(found, h5py.Dataset):
        raise DamageError(f"{path} is no dataset")
    plain_type(found.dtype, path)
    properties = found.id.get_create_plist()
    layout = properties.get_layout()
    if layout not in (h5py.h5d.CONTIGUOUS, h5py.h5d.CHUNKED) or properties.get_external_count():
        raise DamageError(f"{path} keeps its values elsewhere")
    if properties.get_nfilters():
        raise DamageError(f"{path} is compressed or filtered")
    if found.shape is None:
        raise DamageError(f"{path} has no shape")
    if layout == h5py.h5d.CHUNKED:
        size = found.dtype.itemsize * int(np.prod(properties.get_chunk(), dtype=object))
        if size > MOST_CHUNK:
            raise DamageError(f"{path} has chunks of {size} bytes")
    elif byte_size(found.shape, found.dtype):
        offset = found.id.get_offset()
        if offset is None or offset + byte_size(found.shape, found.dtype) > gate.size:
            raise DamageError(f"{path} is not in the file")
    return found


def byte_size(shape: tuple[int, ...], dtype: np.dtype) -> int:
    """Bytes of an array, however many they are."""
    return int(np.prod(shape, dtype=object)) * dtype.itemsize


def rows(found: h5py.Dataset, gate: Gate, count: int) -> None:
    """Check that the first ``count`` rows of a dataset are there, the last one where it should be."""
    if len(found) < count:
        raise DamageError(f"{found.name} has {len(found)} of {count} committed rows")
    if byte_size((count, *found.shape[1:]), found.dtype) > gate.size:
        raise DamageError(f"the file is too short for the {count} rows of {found.name}")
    if count and found.chunks:
        stored(found, gate, count - 1)


def stored(found: h5py.Dataset, gate: Gate, i: int) -> None:
    """Check that row ``i`` of a chunked dataset was written and lies within the file."""
    start = (i - i % found.chunks[0],) + (0,) * (found.ndim - 1)
    if any(n < size for n, size in zip(found.chunks[1:], found.shape[1:], strict=True)):
        raise DamageError(f"{found.name} has chunks that cut its rows")
    chunk = found.id.get_chunk_info_by_coord(start)
    if chunk.byte_offset is None:
        raise DamageError(f"row {i} of {found.name} was never written")
    if chunk.byte_offset + chunk.size > gate.size:
        raise DamageError(f"its end is missing: row {i} of {found.name} lies behind it")


def plain_type(dtype: np.dtype, path: str) -> None:
    """Check that values are numbers or texts of fixed length, or records of such."""
    for name in dtype.names or ():
        plain_type(dtype[name], f"{path}: {shown_name(name)}")
    base = dtype.subdtype[0] if dtype.subdtype else dtype
    if not dtype.names and (base.kind not in "biufS" or (base.metadata and base.kind != "S")):
        raise DamageError(f"{path} holds values of another kind")


def attributes(found: Any) -> dict[str, Any]:
    """The attributes of a group or dataset, texts and numbers, each of reasonable size."""
    names = list(found.attrs)
    if len(names) > MOST_ATTRIBUTES:
        raise DamageError(f"{found.name} has {len(names)} attributes")
    return {name: attribute(found, name) for name in names}


def attribute(found: Any, name: str) -> Any:
    """One attribute; a text as str. It must be there."""
    if name not in found.attrs:
        raise DamageError(f"{found.name} lacks the attribute {name}")
    handle = found.attrs.get_id(name)
    if handle.get_storage_size() > MOST_ATTRIBUTE:
        raise DamageError(f"the attribute {shown_name(name)} of {found.name} is too large")
    kind = handle.get_type()
    if not isinstance(kind, h5py.h5t.TypeStringID | h5py.h5t.TypeIntegerID | h5py.h5t.TypeFloatID):
        raise DamageError(f"the attribute {shown_name(name)} of {found.name} is of another kind")
    value = found.attrs[name]
    return value.decode("utf-8", "replace") if isinstance(value, bytes) else value


def same_types(dtype: np.dtype, wanted: Mapping[str, Any], path: str) -> None:
    """Check that a table has the fields ``wanted``, each of its type; it may have more."""
    for name, kind in wanted.items():
        if dtype.names is None or name not in dtype.names:
            raise DamageError(f"{path} lacks the column {name}")
        if dtype[name] != kind:
            raise DamageError(f"{path}: the column {name} is of type {dtype[name]}, not {kind}")
