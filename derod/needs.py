"""Packages that a part of derod needs, and a worker without that part may lack."""

from __future__ import annotations

from importlib import import_module
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
        install = INSTALLED_AS.get(package, package)
        if getattr(error, "name", None) not in (None, package):
            raise MissingError(
                f"{what} needs {install}, which cannot be imported: {error}"
            ) from error
        raise MissingError(
            f"{what} needs {install}, which is not installed: pip install {install}"
        ) from error
