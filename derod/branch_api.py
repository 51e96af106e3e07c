"""``derod.branch`` and ``derod.compare``: solution branches, and runs held against them, from Python."""

from __future__ import annotations

import os
import tempfile
import warnings
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from derod.branches import BranchFile, Parameters, compute_branches
from derod.branches import compare as compare_rows
from derod.branches.files.compare import worst
from derod.branches.files.report import exceeds, report
from derod.branches.files.writing import BranchWriter, Settings
from derod.branches.paths.arc import Control
from derod.branches.paths.compute import family
from derod.errors import SceneError
from derod.record import BaseRun, open_run
from derod.scene import Scene
from derod.scene.axis import both
from derod.scene.html import html_table
from derod.scenes import read_scene
from derod.views.branch_faces import Branches

AnyPath = str | os.PathLike[str]


LIMITS = {"tolerance": 1e-10, "max_step": 0.22, "accuracy": 1e-8}
"""Of the continuation, unless ``branch`` is told others."""


class BranchWarning(UserWarning):
    """A path that was asked for and not found."""


def branch(
    scene: Scene | AnyPath,
    path: AnyPath | None = None,
    *,
    paths: Sequence[str] | str | None = None,
    stability: bool = True,
    overwrite: bool = False,
    progress: bool = False,
    **limits: float,
) -> Branches:
    """Compute the solution branches of ``scene`` and return them, open for reading.

    ``scene``: a scene, a file, or a shipped one's name. With ``path`` they are kept in that branch file.
    ``paths``: names such as "Ax" or ["Ax", "3D"], all if None. ``stability``: whether unstable modes are
    counted. ``limits`` are those of LIMITS: ``tolerance``, the largest residual; ``max_step``, of arclength;
    ``accuracy``, the mesh-halving error allowed. Paths that are not found are told by a BranchWarning. Raises
    SceneError, RecordError.
    """
    names = (paths,) if isinstance(paths, str) else None if paths is None else tuple(paths)
    for name in names or ():
        try:
            family(name)
        except ValueError as error:
            raise SceneError(str(error)) from error
    for option, value in limits.items():
        if option not in LIMITS:
            raise TypeError(f"branch() got an unexpected keyword argument {option!r}")
        if not 0.0 < value < 1.0:
            raise SceneError("is out of range", key=option, value=value, allowed="between 0 and 1")
    made = scene if isinstance(scene, Scene) else read_scene(scene)
    parameters = Parameters.from_scene(made)
    chosen = LIMITS | limits
    settings = Settings(
        names, chosen["tolerance"], chosen["max_step"], chosen["accuracy"], stability
    )
    if path is not None:
        _compute(path, parameters, made, settings, overwrite, progress)
        return Branches(Path(path))
    with tempfile.TemporaryDirectory(prefix="derod-") as folder:
        passing = Path(folder) / "branches.h5"
        _compute(passing, parameters, made, settings, False, progress)
        file = Branches(passing)
        file.values()  # read: the file is gone when this returns
        file.path = Path("in memory")
        return file


def _compute(
    path: AnyPath,
    parameters: Parameters,
    scene: Scene,
    settings: Settings,
    overwrite: bool,
    progress: bool,
) -> None:
    control = Control(
        tolerance=settings.tolerance,
        largest_step=settings.max_step,
        accuracy=settings.accuracy,
    )
    tell = print if progress else lambda line: None
    with BranchWriter(Path(path), parameters, scene.text, settings, overwrite=overwrite) as writer:
        _, complaints = compute_branches(
            parameters, settings.paths, control, settings.count_modes, tell, writer.put
        )
        writer.put(complete=True)
    for line in complaints:
        warnings.warn(line, BranchWarning, stacklevel=3)


@dataclass(frozen=True, repr=False)
class Comparison:
    """A run held against branches, row by row."""

    table: np.ndarray
    """Of ``derod.branches.files.compare.ROW``: row, end_shortening, branch, and the errors."""

    @property
    def worst(self) -> dict[str, tuple[float, float]]:
        """For each error the largest over the rows on branches, and the end-shortening (D) there."""
        return worst(self.table)

    @property
    def on_branches(self) -> int:
        """How many rows lie on a branch."""
        return int(np.count_nonzero(self.table["branch"] != ""))

    def exceeds(self, tolerance: float = 5e-4) -> bool:
        """Whether t or E_hat is off by more, a length by twice that, or a row by a branch."""
        return exceeds(self.table, tolerance)

    def __len__(self) -> int:
        return len(self.table)

    def __str__(self) -> str:
        return report(self.table, quiet=False)

    def __repr__(self) -> str:
        errors = ", ".join(f"{name} {value:.1e}" for name, (value, _) in self.worst.items())
        return f"<comparison: {self.on_branches} of {len(self)} rows on a branch; worst {errors}>"

    def _repr_html_(self) -> str:
        rows = [(name, f"{value:.2e}", both(at)) for name, (value, at) in self.worst.items()]
        title = f"{self.on_branches} of {len(self)} rows lie on a branch"
        return html_table(title, ("worst", "error", "at end-shortening"), rows)


def compare(run: BaseRun | AnyPath, branches: BranchFile | AnyPath, every: int = 1) -> Comparison:
    """Hold every ``every``-th row of a run against the branches of the same rod.

    Both may be open or named by their paths. Each row is held against the states solved at its own
    end-shortening. Errors of t and E_hat are relative, of wetted length and shape in D. Raises SceneError
    where the rods differ, RecordError for files that are not what they should be.
    """
    if every < 1:
        raise SceneError("is out of range", key="every", value=every, allowed="1, 2, 3, ...")
    if not isinstance(run, BaseRun):
        with open_run(run) as opened:
            return compare(opened, branches, every)
    if not isinstance(branches, BranchFile):
        with Branches(Path(branches)) as file:
            return compare(run, file, every)
    result: Any = compare_rows(run, branches, every)
    return Comparison(result)
