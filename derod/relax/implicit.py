"""Implicit relaxation: damped steps on the bordered band, Newton's at the end (``core.newton``)."""

from __future__ import annotations

import numpy as np

from derod.core import newton
from derod.relax.loop import Report
from derod.state import State
from derod.system import System


class Implicit:
    """Pseudo-transient continuation and Newton's method."""

    limit = 400
    easy, hard = 4, 10
    finest = 0.0

    def begin(self, system: System, state: State, tolerance: float, *, descend: bool) -> Report:
        """Take the residual of the state."""
        self.system, self.state, self.tolerance = system, state, tolerance
        self.descend = descend
        self.shift = 0.0
        self.work = (
            np.zeros_like(state.q),
            np.zeros_like(state.b),
            np.zeros_like(state.q),
            np.zeros_like(state.b),
        )
        sound = system.gradient(state) and system.wall_gap(state) > 0
        return Report(0, *system.excess(tolerance), alive=True, sound=sound)

    def advance(self) -> Report:
        """Take one damped step."""
        system, state = self.system, self.state
        moved, self.shift, state.holonomy, excess, residual = newton.newton_step(
            system.physics,
            system.mesh,
            system.end_rotation,
            self.tolerance,
            self.descend,
            self.shift,
            state.holonomy,
            system.room,
            system.factor,
            state.q,
            state.b,
            *self.work,
        )
        return Report(1, excess, residual, alive=moved, sound=True)
