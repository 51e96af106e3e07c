"""Files that are written whole or not at all, and never over another by accident."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path

from derod.exits import UsageError


def check_target(path: Path, force: bool, endings: Sequence[str], option: str = "-o") -> None:
    """Raise UsageError where ``path`` may not be written: ending, folder, or a file that is there."""
    allowed = " or ".join(f".{ending}" for ending in endings)
    if path.suffix.lower() not in {f".{ending}" for ending in endings}:
        raise UsageError(f"{option} = {path}: allowed: a name that ends in {allowed}")
    if not path.parent.is_dir():
        raise UsageError(
            f"{option} = {path}: no such folder; allowed: a file in an existing folder"
        )
    if path.is_dir():
        raise UsageError(f"{option} = {path}: is a folder; allowed: a file that ends in {allowed}")
    if path.exists() and not force:
        raise UsageError(
            f"{option} = {path}: exists; allowed: another name, or --force to replace it"
        )


def write_file(path: Path, data: bytes, force: bool, option: str = "-o") -> None:
    """Write ``data`` under a temporary name and move it into place. Raises UsageError."""
    partial = path.with_name(path.name + ".part")
    try:
        try:
            partial.write_bytes(data)
            if force:
                partial.replace(path)
            else:
                _place(partial, path)
        finally:
            with suppress(FileNotFoundError):
                partial.unlink()
    except FileExistsError:
        raise UsageError(
            f"{option} = {path}: exists; allowed: another name, or --force to replace it"
        ) from None
    except OSError as error:
        raise UsageError(f"{option} = {path}: cannot be written: {error.strerror}") from None


def _place(partial: Path, path: Path) -> None:
    """Give ``partial`` the name ``path``; unlike a move, refused where a file came in between."""
    try:
        path.hardlink_to(partial)
    except FileExistsError:
        raise
    except OSError:  # a file system without links
        if path.exists():
            raise FileExistsError(path) from None
        partial.replace(path)
