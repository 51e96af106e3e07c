"""Names of files that are exported or drawn: an ending that says what they are, and the rule of outputs."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from derod.exits import UsageError
from derod.files.outputs import check_output, replacing


def check_target(path: Path, force: bool, endings: Sequence[str], option: str = "-o") -> None:
    """Raise UsageError where the name's ending is none of ``endings``, and what ``check_output`` raises."""
    allowed = " or ".join(f".{ending}" for ending in endings)
    if path.suffix.lower() not in {f".{ending}" for ending in endings}:
        raise UsageError(f"{option} = {path}: allowed: a name that ends in {allowed}")
    check_output(path, force=force, make_folders=False)


def write_file(path: Path, data: bytes, force: bool) -> None:
    """Write ``data`` under a passing name and move it into place (``derod.files.outputs``)."""
    with replacing(path, force=force) as passing:
        passing.write_bytes(data)
