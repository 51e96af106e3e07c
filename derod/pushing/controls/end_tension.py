"""The pull T of a dead load on the end clamp, which slides along the axis. Its conjugate is delta."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from derod.equilibrium.control import Constant
from derod.rod.state import State

if TYPE_CHECKING:
    from derod.equilibrium.measured import Measured
    from derod.equilibrium.system import System


class EndTension(Constant):
    """The end clamp slides under a pull; the end-shortening is an unknown."""

    name = "end_tension"
    symbol = "T"
    unit = "K0 D-2"
    power = 1
    conjugate_symbol = r"\delta"

    def conjugate(self, here: Measured) -> float:
        """Return delta, D."""
        return here.state.end_shortening

    def column(self, system: System, state: State) -> tuple[np.ndarray, np.ndarray]:
        """Return 1 in the row of z_N."""
        column, border = system.empty_column()
        column[-1, system.dimension - 1] = 1.0
        return column, border
