"""Uncertain values carried through pushes: by samples, or to first order by differences.

By samples the bands are quantiles over the points of the sweep at each landing. By differences (the design
``differences``: the means, then each value a standard deviation up and down)

    u_t^2 = sum_i ((t(x_i + u_i) - t(x_i - u_i))/2)^2        (JCGM 100:2008, GUM, 5.1.2 and its note 2)

all values being independent.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from derod.errors import SceneError
from derod.scene import Scene
from derod.scene.material import plain_material

if TYPE_CHECKING:
    from derod.sweeps.files import Sweep

QUANTILES = {"low_95": 0.025, "low_68": 0.16, "middle": 0.5, "high_68": 0.84, "high_95": 0.975}
BANDS = np.dtype(
    [
        ("end_shortening", "f8"),
        ("points", "i8"),
        ("mean", "f8"),
        ("deviation", "f8"),
        *((name, "f8") for name in QUANTILES),
    ]
)


def uncertain_keys(scene: Scene, file: str | None = None) -> dict[str, Any]:
    """The values of [material] that have an uncertainty, as a sweep's keys. Raises SceneError."""
    written = {} if scene.material is None else plain_material(scene.material)
    found = {
        f"material.{name}": text
        for name, text in written.items()
        if getattr(scene.material, name).error > 0.0
    }
    if not found:
        raise SceneError("has no value with an uncertainty", file=file or scene.path, key="material",
                         allowed="such as diameter = '5.6 +- 0.5 um'")  # fmt: skip
    return found


def bands(sweep: Sweep, column: str = "end_tension") -> np.ndarray:
    """The column's spread at every landing that all completed pushes have, (k,) of ``BANDS``.

    Raises SceneError where the sweep kept no rows that can be compared.
    """
    complete = sweep.outcomes["point"][sweep.outcomes["outcome"] == b"completed"]
    rows = sweep.rows[np.isin(sweep.rows["point"], complete)]
    places, which = np.unique(np.round(rows["end_shortening"], 9), return_inverse=True)
    shared = np.flatnonzero(np.bincount(which) == len(complete)) if len(rows) else np.zeros(0, int)
    if len(complete) < 2 or not len(shared):
        raise SceneError("has no end-shortening at which two pushes can be compared", file=sweep.path,
                         key="table.rows", value=sweep.plan.rows, allowed="landings")  # fmt: skip
    table = np.zeros(len(shared), BANDS)
    for row, k in zip(table, shared, strict=True):
        chosen = rows[which == k]
        row["end_shortening"], row["points"] = places[k], len(chosen)
        if sweep.plan.design == "differences":
            _first_order(row, sweep, chosen, column)
            continue
        values = chosen[column]
        row["mean"], row["deviation"] = values.mean(), values.std(ddof=1)
        for name, share in QUANTILES.items():
            row[name] = np.quantile(values, share)
    return table


def _first_order(row: Any, sweep: Sweep, rows: np.ndarray, column: str) -> None:
    by_point = dict(zip(rows["point"].tolist(), rows[column].tolist(), strict=True))
    if len(by_point) < len(sweep):
        raise SceneError("lacks a point: differences need all", file=sweep.path, key="outcome",
                         allowed="a sweep without failures, or samples")  # fmt: skip
    shares = [0.5 * (by_point[2 * k + 1] - by_point[2 * k + 2]) for k in range(len(sweep.keys))]
    middle, deviation = by_point[0], float(np.hypot.reduce(shares))
    row["mean"], row["deviation"], row["middle"] = middle, deviation, middle
    for name, size in (("low_95", -2.0), ("low_68", -1.0), ("high_68", 1.0), ("high_95", 2.0)):
        row[name] = middle + size * deviation
