"""The end rotation R of the end clamp about the axis. Its conjugate is the twisting moment m_3."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from derod.equilibrium.control import Constant
from derod.rod.state import State
from derod.rod.unknowns import MOMENT

if TYPE_CHECKING:
    from derod.equilibrium.measured import Measured
    from derod.equilibrium.system import System


class EndRotation(Constant):
    """The end clamp is turned about the axis."""

    name = "end_rotation"
    symbol = "R"
    unit = "rad"
    conjugate_symbol = "m_3"

    def conjugate(self, here: Measured) -> float:
        """Return m_3 = k3 (R - psi)/l, K/D."""
        return here.reactions.twisting_moment

    def column(self, system: System, state: State) -> tuple[np.ndarray, np.ndarray]:
        """Return 1 in the twisting moment's row: there, l/k3 m_3 = R - psi."""
        column, border = system.empty_column()
        if state.physics.twisting > 0:
            border[MOMENT + system.dimension] = 1.0
        return column, border
