"""The constants of a scene that kernels read: one field a constant of a term.

``Physics`` is a named tuple in units of K and D:

    axis      clamp tangent e_z; its length is the dimension d
    row       as long as a row of unknowns: d places, a tension, and an angle where the section needs one
    length    l
    drop      whether there is one; without, b is idle
    slides    whether the end clamp slides along the axis under a dead load (``terms.load``)
    ...       the terms' constants: k3 and R, f_gamma, v0 and rho, W, T

A state carries its own, since a control changes one of them along a push.
"""

from __future__ import annotations

import collections
from typing import Any

from derod.rod.terms import TERMS
from derod.scene import Scene

AXES = {2: (0.0, 1.0), 3: (0.0, 0.0, 1.0)}
CONSTANTS = {name: make for term in TERMS for name, make in term.constants.items()}

FIELDS = ("axis", "row", "length", "drop", "slides", *CONSTANTS)
named: Any = collections.namedtuple  # fields that are known at run time only
Physics = named("Physics", FIELDS)


def physics_of(scene: Scene) -> Any:
    """Return the constants of a scene."""
    made = {name: float(make(scene)) for name, make in CONSTANTS.items()}
    slides = scene.clamps.end_tension is not None
    return constants(
        scene.model.dimension, scene.rod.length, drop=scene.drop is not None, slides=slides,
        angles=scene.has_frames, **made,
    )  # fmt: skip


def constants(
    dimension: int,
    length: float,
    *,
    drop: bool,
    slides: bool = False,
    angles: bool = False,
    **terms: float,
) -> Any:
    """Return constants by name; those of terms that are not given are 0."""
    given = dict.fromkeys(CONSTANTS, 0.0) | terms
    row = (0.0,) * (dimension + 1 + angles)
    return Physics(AXES[dimension], row, float(length), drop, slides, **given)
