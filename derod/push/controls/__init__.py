"""What a push may change: one control a file, and one line here."""

from derod.equilibrium.control import Control
from derod.push.controls.capillary_force import CapillaryForce
from derod.push.controls.end_rotation import EndRotation
from derod.push.controls.end_shortening import EndShortening
from derod.push.controls.end_tension import EndTension
from derod.push.controls.wall_strength import WallStrength
from derod.push.controls.weight import Weight

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
