"""The drop's weight W, along -y. Its conjugate is y_C."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from derod.equilibrium.control import Constant
from derod.rod.state import State
from derod.rod.unknowns import X_C

if TYPE_CHECKING:
    from derod.equilibrium.measured import Measured
    from derod.equilibrium.system import System


class Weight(Constant):
    """The drop gets heavier, or lighter."""

    name = "weight"
    symbol = "W"
    unit = "K0 D-2"
    power = 1
    conjugate_symbol = "y_C"

    def conjugate(self, here: Measured) -> float:
        """Return y_C, D."""
        return float(here.state.drop_center[1])

    def column(self, system: System, state: State) -> tuple[np.ndarray, np.ndarray]:
        """Return the pull on the drop's centre."""
        column, border = system.empty_column()
        border[X_C + system.dimension - 2] = -1.0
        return column, border
