"""The checksums of a diagram file, and whether its parts are as derod writes them."""

from __future__ import annotations

from typing import Any

import h5py

from derod.diagram.layout import FORMAT, FRAMES, POINT, SPECIAL, SPECIALS, TABLE, TEXTS
from derod.errors import RecordError
from derod.files import checks, digest
from derod.files.gate import Gate, open_gate


def group_check(name: str, group: h5py.Group) -> int:
    """Return the checksum of a path: its name, its texts, its arrays."""
    texts = [
        f"{text}={group.attrs[text]}\0".encode("utf-8", "replace") for text in (*TEXTS, "whole")
    ]
    tables = (
        digest.table_digest(part.encode(), group[part][:]) for part in (TABLE, SPECIALS, *FRAMES)
    )
    parts = (name.encode(), *texts, *(table.to_bytes(8, "little") for table in tables))
    return digest.digest(b"path", 0, parts)


def head_check(file: h5py.File) -> int:
    """Return the checksum of the root: its attributes, and which paths there are."""
    told = {name: value for name, value in checks.attributes(file).items() if name != "check"}
    return digest.head_digest("\0".join(file["paths"]).encode("utf-8", "replace"), {"": told})


def checked_path(file: h5py.File, gate: Gate, name: str) -> tuple[h5py.Group, dict[str, Any]]:
    """Return the group of a path and its attributes, looked at and held against its checksum.

    Raises DamageError.
    """
    place = f"paths/{name}"
    group = checks.part(file, place)
    attributes = checks.attributes(group)
    count = None
    for part in (TABLE, SPECIALS, *FRAMES):
        found = checks.dataset(file, gate, f"{place}/{part}")
        gate.allow(checks.byte_size(found.shape, found.dtype))
        if part == TABLE:
            checks.same_types(found.dtype, {n: POINT[n] for n in POINT.names or ()}, place)
            count = len(found)
        elif part == SPECIALS:
            checks.same_types(found.dtype, {n: SPECIAL[n] for n in SPECIAL.names or ()}, place)
        elif len(found) != count:
            raise checks.DamageError(f"{place}/{part} has {len(found)} of {count} points")
    if group_check(name, group) != attributes.get("check"):
        raise checks.DamageError(f"the path {name} does not fit its checksum")
    return group, attributes


def is_diagram_file(path: str) -> bool:
    """Return whether this is a diagram file; False also for what cannot be read at all."""
    try:
        gate, file = open_gate(path, "a diagram file")
    except RecordError:
        return False
    try:
        return bool(file.attrs.get("format") == FORMAT)
    except checks.TROUBLE:
        return False
    finally:
        gate.shut()
