"""The checksums of run and branch files: 64 bits of BLAKE2b over what a reader will be given.

They are ours, not HDF5's: its checksums cover its own blocks, and say nothing of a frame that was never
written, was overwritten by another, or is looked for in the wrong place.
"""

from __future__ import annotations

import hashlib
import struct
from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np

_INDEX = struct.Struct("<Q")


def digest(kind: bytes, i: int, parts: Iterable[Any]) -> int:
    """The checksum of record ``i`` of a ``kind`` made of ``parts``, bytes or arrays, in order."""
    hashed = hashlib.blake2b(_INDEX.pack(i), digest_size=8, person=kind)
    for part in parts:
        hashed.update(part)
    return int.from_bytes(hashed.digest(), "little")


def frame_digest(i: int, row: bytes, arrays: Iterable[np.ndarray], time: float) -> int:
    """Of frame ``i``: its row without the check, its arrays in the layout's order, step and time."""
    return digest(b"frame", i, (row, *arrays, struct.pack("<qd", i, time)))


def record_digest(kind: bytes, i: int, record: np.void) -> int:
    """Of record ``i`` of a table, its last field, the check, left out."""
    return digest(kind, i, (record.tobytes()[:-8],))


def committed_digest(frames: int, events: int) -> int:
    """Of the commit counter."""
    return digest(b"committed", 0, (struct.pack("<qq", frames, events),))


def table_digest(kind: bytes, table: np.ndarray) -> int:
    """Of an array as a whole: its type, its shape and its values."""
    description = f"{table.dtype.descr} {table.shape}".encode()
    return digest(kind, 0, (description, np.ascontiguousarray(table).tobytes()))


def head_digest(scene: bytes, attributes: Mapping[str, Mapping[str, Any]]) -> int:
    """Of the scene's text and the attributes, by object and name, of everything else."""
    parts = [scene]
    for place in sorted(attributes):
        for name in sorted(attributes[place]):
            value = np.asarray(attributes[place][name])
            parts.append(f"\0{place}\0{name}\0{value.tolist()!r}".encode("utf-8", "replace"))
    return digest(b"head", 0, parts)
