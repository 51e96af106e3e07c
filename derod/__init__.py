"""derod: dynamic relaxation of a discrete elastic rod that coils inside a liquid drop.

::

    run = derod.push("quick")  # a scene that ships; or a file, or derod.Scene(...)
    run.plot()
    run["end_tension"], run[-1].positions, run.at("0.5 pi").curvature

What is named here is imported when it is first used, so that ``import derod`` costs nothing.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from derod.api import push as push
    from derod.branch_api import Comparison as Comparison
    from derod.branch_api import branch as branch
    from derod.branch_api import compare as compare
    from derod.errors import DerodError as DerodError
    from derod.errors import RecordError as RecordError
    from derod.errors import SceneError as SceneError
    from derod.pushing.frames import Ending as Ending
    from derod.pushing.frames import Event as Event
    from derod.pushing.frames import Frame as Frame
    from derod.pushing.frames import Observer as Observer
    from derod.pushing.frames import Outcome as Outcome
    from derod.record import open_run as open_run
    from derod.record.extrapolate import extrapolate as extrapolate
    from derod.scene import load_scene as load_scene
    from derod.scene import parse_scene as parse_scene
    from derod.scene.building import Scene as Scene
    from derod.sweeps.files import Sweep as Sweep
    from derod.sweeps.files import open_sweep as open_sweep
    from derod.views.branch_faces import open_branches as open_branches
    from derod.views.sweeping import sweep as sweep

__version__ = "0.2.0"

_HOMES = {
    "Comparison": "derod.branch_api",
    "DerodError": "derod.errors",
    "Ending": "derod.pushing.frames",
    "Event": "derod.pushing.frames",
    "Frame": "derod.pushing.frames",
    "Observer": "derod.pushing.frames",
    "Outcome": "derod.pushing.frames",
    "RecordError": "derod.errors",
    "Scene": "derod.scene.building",
    "SceneError": "derod.errors",
    "Sweep": "derod.sweeps.files",
    "branch": "derod.branch_api",
    "compare": "derod.branch_api",
    "extrapolate": "derod.record.extrapolate",
    "load_scene": "derod.scene",
    "open_branches": "derod.views.branch_faces",
    "open_run": "derod.record",
    "open_sweep": "derod.sweeps.files",
    "parse_scene": "derod.scene",
    "push": "derod.api",
    "sweep": "derod.views.sweeping",
}


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module 'derod' has no attribute {name!r}")
    value = getattr(import_module(_HOMES[name]), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *_HOMES})
