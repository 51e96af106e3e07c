"""What a control, the parameter that a push changes, must tell of itself."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import TYPE_CHECKING

import numpy as np

from derod.rod.state import State

if TYPE_CHECKING:
    from derod.equilibrium.measured import Measured
    from derod.equilibrium.system import System


class Control(ABC):
    """A parameter p of the potential, with its conjugate, the potential's derivative by it.

    Values are in the rod's units, D and its bending stiffness K; ``power`` tells how K enters.
    """

    name: str
    """In scenes (``push.control``, ``derod.scene.controls``), as a column, and as its axis everywhere."""
    symbol: str
    """For labels, in LaTeX."""
    unit: str
    """In files: "D", "rad", "K0 D-2"."""
    power = 0
    """1 where it counts in K: its value in a file is that times ``rod.bending``."""
    conjugate_symbol: str

    @abstractmethod
    def value(self, state: State) -> float:
        """Return the value a state has."""

    @abstractmethod
    def set(self, state: State, value: float) -> None:
        """Give a state the value, in place; it is no equilibrium then."""

    @abstractmethod
    def conjugate(self, here: Measured) -> float:
        """Return the derivative of the potential by this parameter, the state relaxed or not."""

    @abstractmethod
    def column(self, system: System, state: State) -> tuple[np.ndarray, np.ndarray]:
        """Return minus the residual's derivative by this parameter, (N, w) and like the border.

        The state is the one whose Hessian was filled last.
        """

    def own(self, system: System) -> float:
        """Return the potential's second derivative by this parameter alone, the state held."""
        return 0.0

    def moves_end(self) -> float:
        """Return how far the end clamp moves along the axis for a unit of this parameter."""
        return 0.0


class Constant(Control):
    """A control that is a constant of ``Physics`` of the same name."""

    def value(self, state: State) -> float:
        """Return the constant."""
        return float(getattr(state.physics, self.name))

    def set(self, state: State, value: float) -> None:
        """Give the state another constant."""
        state.physics = state.physics._replace(**{self.name: value})
