"""The dimensionless numbers of one half-rod problem."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from derod.errors import SceneError
from derod.scene.material import check_one_stiffness

if TYPE_CHECKING:
    from derod.scene import Scene


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
    """K/K0: all of the above is in units of K; what is reported is multiplied back to units of
    K0."""

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
    def from_scene(cls, scene: Scene) -> Parameters:
        """Take the numbers of a scene, forces divided by its bending stiffness.

        Raises SceneError for a rod with two bending stiffnesses (the flip-symmetric equations are
        those of isotropic rods), and for a drop without capillary force or wall.
        """
        check_one_stiffness(scene)
        bending = scene.rod.bending
        if not isinstance(bending, int | float):
            raise SceneError(
                "has no branches: the paper's boundary-value problem is for isotropic rods",
                file=scene.path,
                key="rod.bending",
                value=bending,
                allowed="one number",
            )
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
        return cls(
            length=scene.rod.length,
            twisting=scene.rod.twisting / bending,
            capillary_force=scene.require_drop().capillary_force / bending,
            wall_strength=scene.require_drop().wall_strength / bending,
            wall_softness=scene.require_drop().wall_softness,
            end_rotation=scene.clamps.end_rotation,
            weight=scene.require_drop().weight / bending,
            bending=bending,
        )
