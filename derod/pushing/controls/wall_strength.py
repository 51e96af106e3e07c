"""The wall's strength v0. Its conjugate is E_wall / v0."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from derod.equilibrium.control import Constant
from derod.rod.state import State

if TYPE_CHECKING:
    from derod.equilibrium.measured import Measured
    from derod.equilibrium.system import System


class WallStrength(Constant):
    """The wall pushes more strongly, or less."""

    name = "wall_strength"
    symbol = "v_0"
    unit = "K0 D-2"
    power = 1
    conjugate_symbol = r"E_{wall} / v_0"

    def conjugate(self, here: Measured) -> float:
        """Return E_wall / v0, D."""
        return here.energies.parts["wall"] / here.state.physics.wall_strength

    def column(self, system: System, state: State) -> tuple[np.ndarray, np.ndarray]:
        """Return minus the wall's own gradient over v0: the residual is linear in v0."""
        column, border = system.empty_column()
        room, size = system.room, state.b.size
        r, rb = room.r.copy(), room.rb.copy()
        twice = state.copy()
        strength = self.value(state)
        self.set(twice, 2 * strength)
        system.gradient(twice)
        column[:-1] = (r - room.r)[1:-1] / strength  # no wall at the end clamp
        border[:size] = (rb - room.rb) / strength
        system.gradient(state)
        return column, border
