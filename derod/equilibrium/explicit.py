"""Explicit dynamic relaxation: FIRE and kinetic damping (``equilibrium.dynamics``)."""

from __future__ import annotations

from derod.equilibrium import dynamics as explicit
from derod.equilibrium import masses
from derod.equilibrium.loop import Report
from derod.equilibrium.system import System
from derod.rod.residual import EPS
from derod.rod.state import State
from derod.rod.unknowns import ETA, F_A, S_A, S_B

BATCH = 500  # steps between two looks at the masses
ROUNDING = 16.0  # a tension lambda + kappa g is known to kappa times the rounding of a position
FIRST_LEVEL = 1e-2  # K0/D^2, of the forces at the first renewal of the multipliers


class Explicit:
    """Second-order dynamics with fictitious masses; the limit of steps grows with the mesh."""

    limit = 400_000
    easy, hard = 500_000, 2_000_000
    finest = 1e-7  # leaves 1e-8 in E_hat and 1e-6 in t; the steps grow with its logarithm
    tolerance = 0.0
    stepwise = False

    def __init__(self, *, kinetic: bool) -> None:
        self.kinetic = kinetic

    def begin(
        self, system: System, state: State, tolerance: float, *, descend: bool, kick: float = 0.0
    ) -> Report:
        """Take the residual of the state, and start at rest; the way is downhill in any case."""
        self.system, self.state = system, state
        d = system.dimension
        if system.physics.drop:  # the menisci only move as mirror images from here on
            off = 0.5 * (state.b[S_A] + state.b[S_B] - system.physics.length)
            state.b[S_A] -= off
            state.b[S_B] -= off
        sound = system.gradient(state) and system.wall_gap(state) > 0
        self.inertia = masses.new_inertia(system.edges, d)
        masses.fill_penalties(system.room.kin, self.inertia)
        stiffest = float(self.inertia.penalty.max())
        self.tolerance = max(tolerance, ROUNDING * EPS * system.physics.length * stiffest)
        report = Report(0, *system.excess(state, self.tolerance), alive=True, sound=sound)
        self.motion = explicit.new_motion(system.edges, d)
        self.motion.tension[:] = state.q[:, d]
        self.motion.force[:] = state.b[F_A + d : ETA + d]
        self.motion.memory[explicit.LEVEL] = max(FIRST_LEVEL, explicit.RENEW * report.residual)
        if self.kinetic:
            self.motion.memory[explicit.STEP] = explicit.LARGEST_STEP
        return report

    def advance(self) -> Report:
        """Take a batch of steps with fresh masses."""
        self.fill_masses()
        return self.take_steps()

    def fill_masses(self) -> None:
        """Make the step 1 stable for the state as it is."""
        system, state = self.system, self.state
        system.gradient(state)
        masses.fill_masses(
            state.physics,
            state.q,
            state.b,
            state.holonomy,
            system.room,
            system.factor,
            self.inertia,
        )

    def take_steps(self) -> Report:
        """Take a batch of steps."""
        system, state = self.system, self.state
        done, state.holonomy, excess, residual, sound = explicit.explicit_steps(
            state.physics,
            system.mesh,
            self.tolerance,
            self.kinetic,
            BATCH,
            state.holonomy,
            system.room,
            state.q,
            state.b,
            self.inertia,
            self.motion,
        )
        return Report(done, excess, residual, alive=True, sound=sound)
