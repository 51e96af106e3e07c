"""derod: dynamic relaxation of a discrete elastic rod that coils inside a liquid drop.

::

    scene = derod.load_scene("runs/quick.toml")
    run = derod.push(scene, "coil.h5")
    run.table["end_tension"], run.positions(-1)

What is named here is imported when it is first used, so that ``import derod`` costs nothing.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from derod.api import push as push
    from derod.branches import open_branches as open_branches
    from derod.errors import DerodError as DerodError
    from derod.errors import RecordError as RecordError
    from derod.errors import SceneError as SceneError
    from derod.record import open_run as open_run
    from derod.record.extrapolate import extrapolate as extrapolate
    from derod.scene import load_scene as load_scene
    from derod.scene import parse_scene as parse_scene

__version__ = "0.1.0"

_HOMES = {
    "DerodError": "derod.errors",
    "RecordError": "derod.errors",
    "SceneError": "derod.errors",
    "extrapolate": "derod.record.extrapolate",
    "load_scene": "derod.scene",
    "open_branches": "derod.branches",
    "open_run": "derod.record",
    "parse_scene": "derod.scene",
    "push": "derod.api",
}


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module 'derod' has no attribute {name!r}")
    value = getattr(import_module(_HOMES[name]), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *_HOMES})
