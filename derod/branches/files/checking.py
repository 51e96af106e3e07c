"""What a branch file must be before it is read, and its checksums."""

from __future__ import annotations

import os
from collections.abc import Mapping
from typing import Any

import h5py
import numpy as np

from derod.branches.files.layout import BIFURCATION, FORMATS, POINT
from derod.errors import RecordError, shown_name
from derod.files import checks, digest
from derod.files.gate import Gate, open_gate

DamageError = checks.DamageError
DATASETS = ("table", "bifurcations", "nodes", "eta")
TEXTS = ("begins", "ends", "remarks", "mirror")
MOST_BRANCHES = 1000
NODE = 10
"""Numbers of a node (``state.HalfRod``)."""
UNTOLD = ("check", "complete")
"""Attributes of the root that its checksum does not cover: itself, and what the checksum's kind says."""


def format_of(path: str, file: h5py.File) -> str:
    """The version of the layout; raises RecordError for another kind of file."""
    if "derod_format" in file.attrs:
        raise RecordError(f"{path}: is a run file, not a branch file: try derod info {path}")
    if "format" not in file.attrs:
        raise RecordError(f"{path}: not a branch file of derod")
    found = str(checks.attribute(file, "format"))
    if found not in FORMATS:
        raise RecordError(
            f"{path}: not a branch file ({shown_name(found)}; allowed: {', '.join(FORMATS)})"
        )
    return found


def number(attributes: Mapping[str, Any], name: str) -> float:
    """A parameter, finite; raises DamageError."""
    value = attributes.get(name)
    if value is None or np.ndim(value) or not np.isfinite(float(value)):
        raise DamageError(f"the parameter {name} is {shown_name(value)}")
    return float(value)


def branch_names(file: h5py.File) -> list[str]:
    """The names of the branches, in the file's order."""
    group = checks.part(file, "branches")
    if not isinstance(group, h5py.Group) or len(group) > MOST_BRANCHES:
        raise DamageError("its branches are of another kind")
    return list(group)


def checked_group(file: h5py.File, gate: Gate, name: str, checksummed: bool) -> h5py.Group:
    """The group of a branch, every part of it looked at; raises DamageError."""
    gate.allow(0)
    place = f"branches/{name}"
    group = checks.part(file, place)
    if not isinstance(group, h5py.Group):
        raise DamageError(f"{place} is no group")
    found = {part: checks.dataset(file, gate, f"{place}/{part}") for part in DATASETS}
    for part in DATASETS:
        checks.rows(found[part], gate, len(found[part]))
    gate.allow(gate.size)
    _same(found["table"], POINT, place)
    _same(found["bifurcations"], BIFURCATION, place)
    if found["nodes"].shape[1:] != (NODE,) or found["eta"].ndim != 1:
        raise DamageError(f"{place} has arrays of another shape")
    texts = checks.attributes(group)
    for text in TEXTS:
        if not isinstance(texts.get(text), str):
            raise DamageError(f"{place} lacks the attribute {text}")
    _check_counts(found, place)
    if checksummed and group_check(name, group) != texts.get("check"):
        raise DamageError(f"{place} does not fit its checksum")
    return group


def _same(found: h5py.Dataset, dtype: np.dtype, place: str) -> None:
    fields = {name: dtype[name] for name in dtype.names or ()}
    if found.ndim != 1:
        raise DamageError(f"{place} has a table of another shape")
    checks.same_types(found.dtype, fields, place)


def _check_counts(found: Mapping[str, h5py.Dataset], place: str) -> None:
    table = found["table"][:]
    elements, inner = table["elements"].astype(np.int64), table["inner"].astype(np.int64)
    if (elements < 1).any() or (inner < 0).any() or (inner > elements).any():
        raise DamageError(f"{place} has points of impossible meshes")
    total = int(elements.sum())
    if len(found["eta"]) != total or len(found["nodes"]) != total + 2 * len(table):
        raise DamageError(f"{place} has too few nodes for its points")
    index = found["bifurcations"][:]["index"]
    if len(index) and (index.min() < 0 or index.max() >= len(table)):
        raise DamageError(f"{place} has special points that lie on none of its own")


def group_check(name: str, group: h5py.Group) -> int:
    """The checksum of a branch: its name, its texts, its arrays."""
    texts = [f"{text}={group.attrs[text]}\0".encode("utf-8", "replace") for text in TEXTS]
    tables = (digest.table_digest(part.encode(), group[part][:]) for part in DATASETS)
    return digest.digest(
        b"branch", 0, (name.encode(), *texts, *(table.to_bytes(8, "little") for table in tables))
    )


def head_check(attributes: Mapping[str, Any], names: list[str]) -> int:
    """The checksum of the root: its attributes, and which branches there are, in order."""
    told = {name: value for name, value in attributes.items() if name not in UNTOLD}
    kind = b"complete" if attributes.get("complete") else b"partial"
    listed = "\0".join(names).encode("utf-8", "replace")
    told_check = digest.head_digest(listed, {"": told})
    return digest.digest(kind, 0, (told_check.to_bytes(8, "little"),))


def is_branch_file(path: str | os.PathLike[str]) -> bool:
    """Whether this is a file of ``derod branch``; False also for what cannot be read at all."""
    try:
        gate, file = open_gate(str(path), "a branch file")
    except RecordError:
        return False
    try:
        with checks.judged(str(path)):
            format_of(str(path), file)
    except RecordError:
        return False
    finally:
        gate.shut()
    return True
