"""Whether a scene goes on where a recorded run stopped."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from derod.errors import SceneError
from derod.scene import Scene
from derod.scene.axis import AXES
from derod.scene.program import Leg, legs

if TYPE_CHECKING:
    from derod.record.run import BaseRun

SAME_TABLES = ("material", "rod", "drop", "clamps", "mesh", "noise", "model")
SAME_KEYS = ("control", "start", "bend")


def check_continues(old: BaseRun, scene: Scene) -> None:
    """Raise SceneError unless ``scene`` is what ``old`` ran, but for where the push goes next."""
    before = old.scene
    for table in SAME_TABLES:
        if getattr(scene, table) != getattr(before, table):
            raise SceneError("differs from the run that is resumed", file=scene.path, key=table)
    for name in SAME_KEYS:
        if getattr(scene.push, name) != getattr(before.push, name):
            key = f"push.{name}"
            raise SceneError("differs from the run that is resumed", file=scene.path, key=key)
    if not len(old):
        return
    was, now, at = legs(before), legs(scene), int(old.table["segment"][-1])
    for i in range(at + 1):
        ended = i < at
        if i >= len(now) or now[i].control != was[i].control or (
            ended and now[i].stop != was[i].stop
        ):  # fmt: skip
            raise SceneError("differs in a leg that is done", file=scene.path, key=was[i].key)
    check_ahead(old, scene, now, at)


def check_ahead(old: BaseRun, scene: Scene, now: tuple[Leg, ...], at: int) -> None:
    """Raise SceneError where the present goal, or a new landing, has been passed."""
    was, leg = legs(old.scene)[at], now[at]
    reached = float(old.table[leg.control][-1])
    told = AXES[leg.control].both(reached)
    first = old.table[old.table["segment"] == at][leg.control][0]
    onward = math.copysign(1.0, was.stop - float(first))
    if (leg.stop - reached) * onward < 0.0:
        raise SceneError(
            "has been passed",
            file=scene.path,
            key=leg.key,
            value=leg.stop,
            allowed=f"{'at least' if onward > 0.0 else 'at most'} {told}, where the run is",
        )
    known = {place for one in legs(old.scene) if same_table(one, leg) for place in one.at}
    for landing in sorted(set(leg.at) - known):
        here = reached
        ahead = False
        for one in now[at:]:
            if not same_table(one, leg):
                break
            ahead |= min(here, one.stop) <= landing <= max(here, one.stop) and landing != reached
            here = one.stop
        if not ahead:
            raise SceneError(
                "has been passed",
                file=scene.path,
                key=f"{leg.key.partition('.')[0]}.at",
                value=landing,
                allowed=f"landings ahead of {told}, where the run is",
            )


def same_table(one: Leg, other: Leg) -> bool:
    """Whether two legs stand in one table of the scene."""
    return one.key.partition(".")[0] == other.key.partition(".")[0]
