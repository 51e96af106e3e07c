"""Packages that a part of derod needs, and a worker without that part may lack."""

from __future__ import annotations

from importlib import import_module
from importlib.util import find_spec
from typing import Any

from derod.errors import DerodError

INSTALLED_AS = {"rerun": "rerun-sdk"}


class MissingError(DerodError, ImportError):
    """A package that is not installed."""


def need(package: str, what: str) -> Any:
    """Import a package that ``what`` (a command, a method) needs; raises MissingError, which names both."""
    try:
        return import_module(package)
    except ImportError as error:
        if getattr(error, "name", None) in (None, package):
            raise _missing(package, what) from None
        install = INSTALLED_AS.get(package, package)
        raise MissingError(f"{what} needs {install}, which cannot be imported: {error}") from error


def check(package: str, what: str) -> None:
    """Raise MissingError where a package is not installed that a child of this process will import."""
    try:
        found = find_spec(package)
    except (ImportError, ValueError):  # blocked, or blocked by None in sys.modules
        found = None
    if found is None:
        raise _missing(package, what)


def _missing(package: str, what: str) -> MissingError:
    install = INSTALLED_AS.get(package, package)
    return MissingError(f"{what} needs {install}, which is not installed: pip install {install}")
