"""What a scene may push with: where each control's value stands, what it may be, and its usual step."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

from derod.scene.tables import Scene

LARGEST = 1e6  # D; beyond it sums of energies have no digits left
STRONGEST = 1e9  # of stiffnesses and forces: any unit K0 will do
WEAKEST = 1e-12


@dataclass(frozen=True, slots=True)
class Held:
    """The key of a scene that holds a control's value while another control pushes."""

    table: str
    words: str
    """For sentences."""
    holds: Callable[[float], bool]
    allowed: str
    step: Callable[[Scene], float]
    """The largest increment, unless the scene tells another."""
    needs: str = ""
    """"drop" or "space"."""


def _euler_share(scene: Scene) -> float:
    """A hundredth of the capillary force, or of the clamped rod's Euler load."""
    if scene.drop is not None:
        return 0.01 * scene.drop.capillary_force
    return 0.04 * math.pi**2 * scene.rod.bending / scene.rod.length**2


FORCE = "a number from 1e-12 to 1e9"
HELD: dict[str, Held] = {
    "end_shortening": Held(
        "clamps",
        "end-shortening",
        lambda x: x > 0.0,
        "an end-shortening above 0, e.g. '2.8 pi'",
        lambda scene: 0.02 * math.pi,
    ),
    "end_tension": Held(
        "clamps",
        "end tension",
        lambda x: abs(x) <= STRONGEST,
        "a number from -1e9 to 1e9",
        _euler_share,
    ),
    "end_rotation": Held(
        "clamps",
        "end rotation",
        lambda x: abs(x) <= LARGEST,
        "an angle in radians, e.g. '2 pi'",
        lambda scene: 0.1 * math.pi,
        needs="space",
    ),
    "capillary_force": Held(
        "drop",
        "capillary force",
        lambda x: WEAKEST <= x <= STRONGEST,
        FORCE,
        lambda scene: 0.02 * scene.require_drop().capillary_force,
        needs="drop",
    ),
    "wall_strength": Held(
        "drop",
        "wall strength",
        lambda x: WEAKEST <= x <= STRONGEST,
        FORCE,
        lambda scene: 0.1 * scene.require_drop().wall_strength,
        needs="drop",
    ),
    "weight": Held(
        "drop",
        "weight",
        lambda x: 0.0 <= x <= STRONGEST,
        "a number from 0 to 1e9",
        lambda scene: 0.01 * scene.require_drop().capillary_force,
        needs="drop",
    ),
}
"""By name, which is the key in its table, ``push.control`` and the table's column."""


def held_value(scene: Scene, control: str) -> float | None:
    """The value that stands in the scene's tables, None where none does."""
    table = getattr(scene, HELD[control].table)
    return None if table is None else getattr(table, control, None)
