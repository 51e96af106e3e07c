"""The dimensionless numbers of one half-rod problem."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from derod.errors import SceneError

if TYPE_CHECKING:
    from derod.scene import Scene

FLIP_TOLERANCE = 1e-9
"""On (alpha_0 + alpha_L)/pi, which must be an integer."""


@dataclass(frozen=True, slots=True)
class Parameters:
    """Parameters of eq:18d-equilibre, in D, K0/D^2 (eq:adim) and radians.

    Defaults are the paper's rod in its text: l = 10, k3 = 0.9, f_gamma = 20, v0 = 2e-4, rho = 0.1.
    """

    length: float = 10.0  # l
    twisting: float = 0.9  # k3
    capillary_force: float = 20.0  # f_gamma
    wall_strength: float = 2e-4  # v0
    wall_softness: float = 0.1  # rho
    end_rotation: float = 0.0  # R
    weight: float = 0.0  # W of the drop, along -e_y
    bending: float = 1.0
    """K1/K0: all of the above is in units of K1; what is reported is multiplied back to units of
    K0."""
    bending_2: float = 1.0
    """K2/K1, the stiffness of bending about d_2 over that about d_1."""
    director: float = 0.0
    """alpha_0: the angle from e_x to d_1 at the clamp s = 0. That at s = l is alpha_0 + R."""

    def __post_init__(self) -> None:
        """Refuse what has no flip-symmetric states. Raises ValueError."""
        if not self.bending_2 > 0.0:
            raise ValueError(f"bending_2 = {self.bending_2:g}: allowed: above 0")
        if not self.anisotropic:
            return
        if not self.twisting > 0.0:
            raise ValueError("twisting = 0: allowed with two bending stiffnesses: above 0")
        if not flip_symmetric(self.director, self.end_rotation):
            raise ValueError(
                f"director = {self.director:g} and end_rotation = {self.end_rotation:g}: allowed with two "
                "bending stiffnesses: alpha_0 = -alpha_L, up to multiples of pi"
            )

    @property
    def anisotropic(self) -> bool:
        """Whether there are two bending stiffnesses."""
        return self.bending_2 != 1.0

    @property
    def isotropic(self) -> Parameters:
        """The rod with K2 = K1."""
        return replace(self, bending_2=1.0)

    @property
    def crossed(self) -> bool:
        """Whether d_1, and not d_2, is along the flip axis e_y at the rod's middle.

        The frame of the equations, d_2 = e_y there, is at -R/2 at the clamp s = 0; the material one at
        alpha_0, and their difference, alpha_0 + R/2, is uniform and a multiple of pi/2.
        """
        return round((2.0 * self.director + self.end_rotation) / math.pi) % 2 == 1

    @property
    def section(self) -> np.ndarray:
        """(k3, k_1, k_2): stiffnesses about d_3, d_1, d_2 of the equations' frame, K1."""
        k = (self.bending_2, 1.0) if self.crossed else (1.0, self.bending_2)
        return np.array([self.twisting, *k])

    @property
    def meniscus_wall(self) -> float:
        """v(sigma) = v0 / rho, the wall potential where the rod crosses the drop's surface."""
        return self.wall_strength / self.wall_softness

    @property
    def wall_radius(self) -> float:
        """(1 + rho)/2, where the wall potential is infinite (D)."""
        return 0.5 * (1.0 + self.wall_softness)

    def with_capillary_force(self, value: float) -> Parameters:
        """The same rod in another liquid."""
        return replace(self, capillary_force=value)

    def with_weight(self, value: float) -> Parameters:
        """The same rod with a heavier or lighter drop (W, K0/D^2)."""
        return replace(self, weight=value)

    @classmethod
    def from_scene(cls, scene: Scene, director: float | None = None) -> Parameters:
        """Take the numbers of a scene, forces divided by its bending stiffness K1.

        ``director``: alpha_0, rad; None: that of the scene's directors, or 0. Raises SceneError for a drop
        without capillary force or wall, for a natural shape, and for a rod with two bending stiffnesses that
        has no twisting stiffness or no flip-symmetric states.
        """
        _check_straight(scene)
        if director is None:
            director = (scene.clamps.directors or (0.0,))[0]
        bending = scene.rod.bending
        bending_2 = scene.rod.bending_2 or bending
        for key in ("capillary_force", "wall_strength"):
            value = getattr(scene.require_drop(), key)
            if not value > 0.0:
                raise SceneError(
                    "has no branches: without it no coil forms inside the drop",
                    file=scene.path,
                    key=f"drop.{key}",
                    value=value,
                    allowed="> 0",
                )
        if bending_2 != bending:
            _check_two(scene, director)
        return cls(
            length=scene.rod.length,
            twisting=scene.rod.twisting / bending,
            capillary_force=scene.require_drop().capillary_force / bending,
            wall_strength=scene.require_drop().wall_strength / bending,
            wall_softness=scene.require_drop().wall_softness,
            end_rotation=scene.clamps.end_rotation,
            weight=scene.require_drop().weight / bending,
            bending=bending,
            bending_2=bending_2 / bending,
            director=director,
        )


def _check_straight(scene: Scene) -> None:
    for name in ("natural_curvature", "natural_twist"):
        value = getattr(scene.rod, name)
        if np.any(value or 0.0):
            raise SceneError(
                "has no branches: they know naturally straight rods",
                file=scene.path,
                key=f"rod.{name}",
                value=list(value) if isinstance(value, tuple) else value,
                allowed="none (derod push takes it)",
            )


def _check_two(scene: Scene, director: float) -> None:
    rotation = scene.clamps.end_rotation
    if not scene.rod.twisting > 0.0:
        raise SceneError(
            "has no branches with two bending stiffnesses",
            file=scene.path,
            key="rod.twisting",
            value=scene.rod.twisting,
            allowed="> 0",
        )
    if not flip_symmetric(director, rotation):
        raise SceneError(
            "has no flip-symmetric states with two bending stiffnesses and d_1 at alpha_0 = "
            f"{director:g} at the first clamp",
            file=scene.path,
            key="clamps.end_rotation",
            value=rotation,
            allowed="-2 alpha_0, up to multiples of pi",
        )


def flip_symmetric(director: float, rotation: float) -> bool:
    """Whether alpha_0 = -alpha_L up to multiples of pi, alpha_L = alpha_0 + R."""
    turns = (2.0 * director + rotation) / math.pi
    return abs(turns - round(turns)) <= FLIP_TOLERANCE
