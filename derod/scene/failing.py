"""The error of a scene whose keys do not go together."""

from __future__ import annotations

from typing import Any, NoReturn

from derod.errors import SceneError
from derod.scene.quantities import write_quantity
from derod.scene.tables import Scene


def fail(scene: Scene, key: str, value: Any, problem: str, allowed: str) -> NoReturn:
    """Raise SceneError, the value written as a scene would have it."""
    written = write_quantity(value) if isinstance(value, float) else None
    raise SceneError(
        problem, file=scene.path, key=key, value=value, allowed=allowed, written=written
    )
