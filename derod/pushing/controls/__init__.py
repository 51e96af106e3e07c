"""What a push may change: one control a file, and one line here."""

from derod.equilibrium.control import Control
from derod.pushing.controls.capillary_force import CapillaryForce
from derod.pushing.controls.end_rotation import EndRotation
from derod.pushing.controls.end_shortening import EndShortening
from derod.pushing.controls.end_tension import EndTension
from derod.pushing.controls.wall_strength import WallStrength
from derod.pushing.controls.weight import Weight

CONTROLS: dict[str, Control] = {
    control.name: control
    for control in (
        EndShortening(),
        EndTension(),
        EndRotation(),
        CapillaryForce(),
        WallStrength(),
        Weight(),
    )
}

__all__ = ["CONTROLS", "Control"]
