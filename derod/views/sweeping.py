"""``derod.sweep``: many pushes from Python."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Mapping
from contextlib import ExitStack
from pathlib import Path
from typing import Any, TypedDict, Unpack

from derod.errors import RecordError, SceneError
from derod.scene import Scene
from derod.scenes import read_scene
from derod.sweeps import engines, running
from derod.sweeps.files import Sweep
from derod.sweeps.plan import make_plan, read_plan
from derod.views.sweep_progress import SweepProgress

DESCRIBED = ("design", "points", "seed", "rows")
"""Options that say what is swept; the others say how."""


class SweepOptions(TypedDict, total=False):
    """The options of ``sweep`` by their names; every one may be left out."""

    design: str
    """"grid" (the default), "list", "latin-hypercube", "sobol" or "differences"."""
    points: int
    """How many, of the last two."""
    seed: int
    """Of the last two."""
    rows: str
    """Which rows of each push are kept: "last" (the default), "landings", "all"."""
    workers: int
    """Processes on this machine: one a core where left out; 1 is this process, without Dask."""
    scheduler: str
    """The address of a Dask cluster that is there."""
    keep_runs: str | os.PathLike[str]
    """A folder for the full runs."""
    resume: bool
    """Go on with the sweep that was begun at ``path``."""
    overwrite: bool
    """Replace ``path``."""
    progress: bool
    """Show a bar."""


def sweep(
    scene: Scene | str | os.PathLike[str] | None,
    keys: Mapping[str, Any] | str | None = None,
    path: str | os.PathLike[str] | None = None,
    **options: Unpack[SweepOptions],
) -> Sweep:
    """Push ``scene`` at many values of its keys and return the sweep, read.

    ::

        forces = {"drop.capillary_force": {"from": 10, "to": 40, "count": 31}, "rod.length": [8, 10]}
        derod.sweep("quick", forces, "forces.h5", progress=True).to_pandas()

    ``scene``: a scene, a file, a shipped one's name; or a sweep file (TOML) where ``keys`` is None.
    ``keys``: what varies ("uncertain": all values of [material] with +-), each a list, an array, a range or
    a distribution (``derod.sweeps.spreads``). With ``path`` finished points are kept as they come, and
    ``resume=True`` (``scene`` may be None) goes on after a kill. In a script, call it under ``if __name__
    == "__main__"``: worker processes import the script. Raises SceneError, RecordError,
    ``derod.needs.MissingError``; points that fail are in ``sweep.failures()``.
    """
    allowed = sorted(SweepOptions.__annotations__)
    for name in options:
        if name not in allowed:
            raise TypeError(f"sweep has no option {name!r}; allowed: {', '.join(allowed)}")
    if options.get("resume") and path is None:
        raise RecordError("a sweep that goes on needs the path of its file")
    given: Mapping[str, Any] = options
    described = {name: given[name] for name in DESCRIBED if name in given}
    plan = None
    if not options.get("resume"):
        if scene is None:
            raise SceneError("a sweep that does not go on with another needs a scene")
        if keys is None and not isinstance(scene, Scene):
            plan = read_plan(scene)
        else:
            base = scene if isinstance(scene, Scene) else read_scene(scene)
            plan = make_plan(base, keys or {}, **described)
    with ExitStack() as stack:
        shown = SweepProgress(everywhere=True) if options.get("progress") else None
        say = nothing if shown is None else shown.say
        kept, scheduler = options.get("keep_runs"), options.get("scheduler")
        means = running.Means(
            workers=engines.workers_or_default(options.get("workers"), scheduler, say),
            scheduler=scheduler,
            runs=None if kept is None else os.fspath(Path(kept).resolve()),
            say=say,
        )
        if shown is not None:
            stack.enter_context(shown)
        if path is None:
            folder = stack.enter_context(tempfile.TemporaryDirectory(prefix="derod-"))
            path = Path(folder) / "sweep.h5"
        overwrite = options.get("overwrite", False)
        running.run_sweep(plan, Path(path), means, overwrite=overwrite, watch=shown or nothing)
        return Sweep(path)


def nothing(told: object) -> None:
    """Let remarks and news pass where nobody wants them."""
