"""The end-shortening delta: the clamps' distance is l - delta. Its conjugate is -t."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from derod.equilibrium.control import Control
from derod.rod.state import State

if TYPE_CHECKING:
    from derod.equilibrium.measured import Measured
    from derod.equilibrium.system import System


class EndShortening(Control):
    """The end clamp is moved along the axis."""

    name = "end_shortening"
    symbol = r"\delta"
    unit = "D"
    conjugate_symbol = "-t"

    def value(self, state: State) -> float:
        """Return delta, D."""
        return state.end_shortening

    def set(self, state: State, value: float) -> None:
        """Put the end clamp where it belongs."""
        state.clamp_at(value)

    def conjugate(self, here: Measured) -> float:
        """Return -t, K/D^2."""
        return -here.tension

    def column(self, system: System, state: State) -> tuple[np.ndarray, np.ndarray]:
        """Return the residual's derivative by z_N: the end moves inward."""
        return system.end_column(state)

    def own(self, system: System) -> float:
        """Return the second derivative by z_N."""
        last = system.dimension - 1
        return float(system.room.hess.edge[system.edges, last, last])

    def moves_end(self) -> float:
        """Return -1: inward."""
        return -1.0
