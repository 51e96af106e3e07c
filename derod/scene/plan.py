"""How large a push is going to be, as far as its scene tells."""

from __future__ import annotations

import math
from typing import NamedTuple

from derod.errors import SceneError
from derod.scene.program import legs, ways
from derod.scene.tables import Scene

MOST_ROWS = 100_000
MOST_BYTES = 20e9
ROW_BYTES = 300
LEAST_STEP = 1e-9
"""Of push.max_step over the largest end-shortening (or D): the driver shortens steps 1e4 times, and
rounding takes 2e-16."""


class Plan(NamedTuple):
    """The least number of rows of a push, and the size of its file."""

    rows: int
    size: int  # bytes

    def __str__(self) -> str:
        return f"at least {self.rows} rows, {size_in_words(self.size)}"


def planned(scene: Scene) -> Plan:
    """What the push of ``scene`` records where no increment has to be shortened."""
    rows = 1 + len(scene.push.at) + sum(len(step.at) for step in scene.steps)
    rows += int(
        sum(
            abs(stop - begin) / leg.max_step
            for (begin, stop), leg in zip(ways(scene), legs(scene), strict=True)
            if not math.isnan(begin)
        )
    )
    edges = scene.mesh.edges
    return Plan(rows, rows * (ROW_BYTES + 8 * (5 * edges + 7)))


def check_plan(scene: Scene) -> None:
    """Raise SceneError for a push that nobody can mean: too many rows, or too large a file."""
    plan = planned(scene)
    if plan.rows <= MOST_ROWS and plan.size <= MOST_BYTES:
        return
    raise SceneError(
        f"plans {plan}",
        file=scene.path,
        key="push.max_step",
        value=scene.push.max_step,
        allowed=f"{MOST_ROWS} rows and {size_in_words(int(MOST_BYTES))}, or --yes-really "
        "(yes_really=True)",
    )


def size_in_words(size: int) -> str:
    """Bytes, readably."""
    amount, unit = float(size), "bytes"
    for unit in ("bytes", "kB", "MB", "GB", "TB", "PB"):  # noqa: B007
        if amount < 1000:
            break
        amount /= 1000
    return f"{amount:.3g} {unit}"
