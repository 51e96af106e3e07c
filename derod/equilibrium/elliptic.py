"""Explicit relaxation with the rod's own elliptic operator as its mass (``equilibrium.accelerated``)."""

from __future__ import annotations

import math

from derod.equilibrium import accelerated
from derod.equilibrium.loop import Report
from derod.equilibrium.motion import new_motion
from derod.equilibrium.system import System
from derod.rod.state import State

BATCH = 200  # steps of one call


class Elliptic:
    """Accelerated gradient steps in the elliptic metric; their number does not grow with the mesh."""

    limit = 20_000
    easy, hard = 150, 1_000
    finest = 1e-8
    tolerance = 0.0
    stepwise = False

    def begin(
        self, system: System, state: State, tolerance: float, *, descend: bool, kick: float = 0.0
    ) -> Report:
        """Take the residual of the state, and start at rest; the way is downhill in any case."""
        self.system, self.state, self.tolerance = system, state, tolerance
        self.motion = new_motion(system.edges, system.dimension)
        sound = system.gradient(state) and system.wall_gap(state) > 0
        _, residual = system.excess(state, tolerance)
        unknown = math.inf  # what is left in soft modes shows in the first step's solution
        return Report(0, unknown, residual, alive=True, sound=sound)

    def advance(self) -> Report:
        """Take a batch of steps."""
        system, state = self.system, self.state
        done, state.holonomy, excess, residual, alive, sound = accelerated.accelerated_steps(
            state.physics,
            system.mesh,
            self.tolerance,
            min(BATCH, self.limit),
            state.holonomy,
            system.room,
            system.factor,
            state.q,
            state.b,
            self.motion,
        )
        return Report(done, excess, residual, alive=alive, sound=sound)
