"""Explicit dynamic relaxation: FIRE and kinetic damping (``core.explicit``)."""

from __future__ import annotations

import numpy as np

from derod.core import explicit
from derod.core.layout import X_C
from derod.relax.loop import Report
from derod.state import State
from derod.system import System

BATCH = 500  # steps between two looks at the masses
FIRST_LEVEL = 1e-2  # K0/D^2, of the forces at the first renewal of the multipliers


class Explicit:
    """Second-order dynamics with fictitious masses; the limit of steps grows with the mesh."""

    limit = 200_000
    easy, hard = 500_000, 2_000_000

    def __init__(self, *, kinetic: bool) -> None:
        self.kinetic = kinetic

    def begin(self, system: System, state: State, tolerance: float, *, descend: bool) -> Report:
        """Take the residual of the state, and start at rest."""
        self.system, self.state, self.tolerance = system, state, tolerance
        d = system.dimension
        sound = system.gradient(state) and system.wall_gap(state) > 0
        report = Report(0, *system.excess(tolerance), alive=True, sound=sound)
        self.base = state.q[:, d].copy()
        self.base_f = state.b[X_C + d : X_C + d + 2].copy()
        self.field = np.zeros((state.q.shape[0], d))
        self.vq = np.zeros((state.q.shape[0], d))
        self.vb = np.zeros(X_C + d)
        self.pq, self.pull = np.zeros_like(self.vq), np.zeros_like(self.vq)
        self.inverse = np.zeros((state.q.shape[0], d, d))
        self.mb = np.ones(X_C + d)
        self.memory = np.zeros(explicit.MEMORY)
        self.memory[explicit.STEP] = 0.1
        self.memory[explicit.MIX] = explicit.FIRE_MIX
        self.memory[explicit.LEVEL] = max(FIRST_LEVEL, explicit.RENEW * report.residual)
        return report

    def advance(self) -> Report:
        """Take a batch of steps with fresh masses."""
        system, state = self.system, self.state
        system.gradient(state)
        self.kappa = explicit.stiffness(system.room.kin)
        explicit.masses(
            system.physics,
            state.q,
            state.b,
            state.holonomy,
            system.end_rotation,
            system.room,
            system.factor,
            self.kappa,
            self.field,
            self.inverse,
            self.mb,
        )
        done, state.holonomy, excess, residual, sound = explicit.explicit_steps(
            system.physics,
            system.mesh,
            system.end_rotation,
            self.tolerance,
            self.kinetic,
            BATCH,
            state.holonomy,
            system.room,
            state.q,
            state.b,
            self.kappa,
            self.base,
            self.base_f,
            self.field,
            self.vq,
            self.pq,
            self.pull,
            self.vb,
            self.inverse,
            self.mb,
            self.memory,
        )
        return Report(done, excess, residual, alive=True, sound=sound)
