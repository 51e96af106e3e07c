"""Richardson extrapolation: two pushes on meshes of h and h/2 give a better one, and its error.

A value of the rod is f(h) = f + c h^p + ..., p = 4 (ARCHITECTURE.md, "The discrete rod"), so that with
r = N_fine / N_coarse

    f = f_fine + e,   e = (f_fine - f_coarse) / (r^p - 1)

|e| is the estimated error of the fine push. That of the extrapolated value is smaller as long as the
meshes are fine enough for the law; two meshes cannot tell by how much.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from derod.errors import SceneError
from derod.pushing.rows import ALL
from derod.record.run import BaseRun
from derod.scene import Scene

ORDER = 4
VALUES = tuple(column.name for column in ALL if column.extrapolates)
UNKNOWN = dict.fromkeys(VALUES, np.nan)
APART = 0.02  # relative; rows whose tension or E_hat differ by more lie on different branches
DTYPE = np.dtype(
    [
        ("increment", "i8"),
        ("end_shortening", "f8"),
        *((name, "f8") for name in VALUES),
        *((f"{name}_error", "f8") for name in VALUES),
    ]
)
"""One row for each of the fine run: values, and the estimated errors of the fine run's values.

Both are NaN where the coarse run has no row in the same state.
"""


def extrapolate(coarse: BaseRun, fine: BaseRun, order: int = ORDER) -> np.ndarray:
    """Return the extrapolated rows of ``fine``, an array of ``DTYPE``; units as in the runs.

    Rows are compared where both runs settled at the same end-shortening on the same leg, with as many
    unstable modes and nearly equal tension and energy. Raises SceneError where the runs differ in more
    than their meshes, or ``coarse`` is not the coarser one.
    """
    ratio = check_pair(coarse.scene, fine.scene)
    partner: dict[tuple[int, float], Any] = {
        (int(row["segment"]), float(row["end_shortening"])): row for row in coarse.table
    }  # the last of those at one place
    out = np.zeros(len(fine), DTYPE)
    weight = 1 / (ratio**order - 1)
    for new, row in zip(out, fine.table, strict=True):
        new["increment"], new["end_shortening"] = row["increment"], row["end_shortening"]
        other = partner.get((int(row["segment"]), float(row["end_shortening"])))
        if other is None or not same_state(row, other):
            other = UNKNOWN
        for name in VALUES:
            correction = weight * (row[name] - other[name])
            new[name], new[f"{name}_error"] = row[name] + correction, abs(correction)
    return out


def same_state(a: np.void, b: np.void) -> bool:
    """Return whether two rows at the same place may be the same state on two meshes."""
    near = all(
        abs(a[name] - b[name]) <= APART * max(abs(a[name]), 1.0)
        for name in ("end_tension", "energy_hat")
    )
    return near and a["unstable_modes"] == b["unstable_modes"]


def check_pair(coarse: Scene, fine: Scene) -> float:
    """Return N_fine / N_coarse; raises SceneError where the scenes are not of one rod."""
    for table in ("rod", "drop", "clamps", "model"):
        if getattr(coarse, table) != getattr(fine, table):
            raise SceneError("of the two runs differ: only their meshes may", key=table)
    for field in fine.mesh.__struct_fields__:
        if field != "edges" and getattr(coarse.mesh, field) != getattr(fine.mesh, field):
            raise SceneError("of the two runs differ: only their edges may", key=f"mesh.{field}")
    ratio = fine.mesh.edges / coarse.mesh.edges
    if ratio < 1.5:
        raise SceneError(
            "of the fine run",
            key="mesh.edges",
            value=fine.mesh.edges,
            allowed=f"1.5 times those of the coarse run, {coarse.mesh.edges}, or more",
        )
    return ratio


def coarser(run: BaseRun) -> Scene:
    """Return the scene of the same push on half the edges, landing on every row of ``run``.

    Raises SceneError where half the edges are too few.
    """
    scene = run.scene
    ends = {scene.push.start, *scene.push.stop}
    places = sorted({float(x) for x in run.table["end_shortening"]} - ends)
    return scene.replace({"mesh.edges": scene.mesh.edges // 2, "push.at": places})
