"""The terms of the energy: their kernels, one a file, and one entry each in this list.

``python -m derod.rod.terms.writing`` writes the sums over the list into ``rod.assembly``. This module
imports no kernel, so that files can be read without numba.
"""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING

from derod.rod.terms.term import Constant, Term

if TYPE_CHECKING:
    from derod.scene import Scene


def of_drop(name: str, scene: Scene) -> float:
    """Return a force of the drop, K/D^2; 0 without a drop."""
    return 0.0 if scene.drop is None else float(getattr(scene.drop, name)) / scene.rod.bending


def of_section(name: str, scene: Scene) -> float:
    """Return a constant of a section with directions; 0 for an isotropic, naturally straight rod."""
    if not scene.has_frames:
        return 0.0
    rod, clamps = scene.rod, scene.clamps
    curvature = rod.natural_curvature or (0.0, 0.0)
    start, end = clamps.directors or (0.0, clamps.end_rotation)
    return {
        "section": 1.0,
        "stiffening": (rod.bending_2 or rod.bending) / rod.bending - 1,
        "natural_curvature_1": curvature[0],
        "natural_curvature_2": curvature[1],
        "director_start": start,
        "director_end": end,
        "torsion": rod.twisting / rod.bending,
        "natural_twist": rod.natural_twist or 0.0,
    }[name]


def section_constants(*names: str) -> dict[str, Constant]:
    """Return the makers of constants of a section."""
    return {name: partial(of_section, name) for name in names}


def end_tension(scene: Scene) -> float:
    """Return the dead load T, K/D^2; 0 where the end-shortening is held."""
    pull = scene.clamps.end_tension
    return 0.0 if pull is None else pull / scene.rod.bending


HOME = __name__
TERMS: list[Term] = [
    Term(f"{HOME}.bending", part="bend"),
    Term(f"{HOME}.defect", part="bend"),
    Term(
        f"{HOME}.wall",
        part="wall",
        needs="drop",
        constants={
            "wall_strength": lambda scene: of_drop("wall_strength", scene),
            "wall_softness": lambda scene: float(scene.drop.wall_softness) if scene.drop else 0.0,
        },
    ),
    Term(
        f"{HOME}.capillary",
        part="capillary",
        needs="drop",
        constants={"capillary_force": lambda scene: of_drop("capillary_force", scene)},
    ),
    Term(
        f"{HOME}.weight",
        part="weight",
        needs="drop",
        constants={"weight": lambda scene: of_drop("weight", scene)},
        breaks_turn="weight",
    ),
    Term(
        f"{HOME}.twist",
        part="twist",
        needs="space",
        constants={
            "twisting": lambda scene: (
                0.0 if scene.has_frames else scene.rod.twisting / scene.rod.bending
            ),
            "end_rotation": lambda scene: float(scene.clamps.end_rotation),
        },
    ),
    Term(
        f"{HOME}.section",
        part="bend",
        constants=section_constants(
            "section",
            "stiffening",
            "natural_curvature_1",
            "natural_curvature_2",
            "director_start",
            "director_end",
        ),
        breaks_turn="section",
    ),
    Term(f"{HOME}.torsion", part="twist", constants=section_constants("torsion", "natural_twist")),
    Term(f"{HOME}.load", part="load", constants={"end_tension": end_tension}),
]
