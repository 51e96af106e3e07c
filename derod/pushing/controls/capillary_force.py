"""The capillary force f_gamma. Its conjugate is -(s_B - s_A)."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from derod.equilibrium.control import Constant
from derod.rod.state import State
from derod.rod.unknowns import S_A, S_B

if TYPE_CHECKING:
    from derod.equilibrium.measured import Measured
    from derod.equilibrium.system import System


class CapillaryForce(Constant):
    """The liquid pulls the rod in more strongly, or less."""

    name = "capillary_force"
    symbol = r"f_\gamma"
    unit = "K0 D-2"
    power = 1
    conjugate_symbol = "-(s_B - s_A)"

    def conjugate(self, here: Measured) -> float:
        """Return -(s_B - s_A), D."""
        s_a, s_b = here.state.menisci
        return s_a - s_b

    def column(self, system: System, state: State) -> tuple[np.ndarray, np.ndarray]:
        """Return the pull on the menisci's places."""
        column, border = system.empty_column()
        border[S_A], border[S_B] = -1.0, 1.0
        return column, border
