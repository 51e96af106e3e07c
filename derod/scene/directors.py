"""What a section with directions of its own needs: its directors at the clamps, and what can relax it."""

from __future__ import annotations

import math

from derod.errors import SceneError
from derod.scene.failing import fail
from derod.scene.program import named_controls
from derod.scene.quantities import write_quantity
from derod.scene.rules import KEYS
from derod.scene.tables import Scene

SAME_ANGLE = 1e-12  # rad
PAIR = KEYS["clamps"]["directors"].allowed


def check_directors(scene: Scene) -> None:
    """Check that the directors agree with the end rotation, and with a plane; raises SceneError."""
    clamps, rod = scene.clamps, scene.rod
    if clamps.directors is not None:
        turn = clamps.directors[1] - clamps.directors[0]
        if abs(clamps.end_rotation - turn) > SAME_ANGLE:
            allowed = f"{write_quantity(turn)}, the difference of clamps.directors, or nothing"
            fail(
                scene,
                "clamps.end_rotation",
                clamps.end_rotation,
                "is not alpha_L - alpha_0",
                allowed,
            )
    if scene.model.dimension == 3:
        return
    for name in ("natural_curvature", "natural_twist"):
        value = getattr(rod, name)
        if value is not None:
            fail(scene, f"rod.{name}", value, "needs space", "none, or model.dimension = 3")
    if rod.bending_2 is None or clamps.directors is None:
        return
    for angle in clamps.directors:
        if abs(math.sin(angle)) > SAME_ANGLE:
            fail(
                scene,
                "clamps.directors",
                list(clamps.directors),
                "do not let a planar rod bend about d_1",
                "[0, 0] with model.dimension = 2",
            )


def check_pushable(scene: Scene) -> None:
    """Raise SceneError for what a push of a section with directions lacks; branches need less."""
    if not scene.has_frames:
        return
    rod, clamps = scene.rod, scene.clamps
    directed = rod.bending_2 is not None or any(rod.natural_curvature or ())
    if directed and clamps.directors is None:
        raise SceneError(
            "is missing: a section with two bending stiffnesses or a natural curvature has directions",
            file=scene.path,
            key="clamps.directors",
            allowed=PAIR,
        )
    if not rod.twisting > 0.0:
        fail(scene, "rod.twisting", rod.twisting, "cannot hold the section's directions", "above 0")
    if scene.relax.method != "implicit":
        fail(
            scene,
            "relax.method",
            scene.relax.method,
            "cannot settle a section with directions",
            "'implicit' with two bending stiffnesses or a natural shape",
        )
    for key, control in named_controls(scene):
        if control == "end_rotation":
            problem = "cannot turn a section with directions yet"
            allowed = "another control with two bending stiffnesses or a natural shape"
            fail(scene, key, control, problem, allowed)
