"""One measured evaluation of a settled state: everything anybody asks of it, taken once.

After it nobody reads the arrays the state was settled in.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from derod.equilibrium.control import Control
from derod.equilibrium.energies import Energies, by_part
from derod.equilibrium.reactions import Reactions, reactions
from derod.equilibrium.readings import readings
from derod.equilibrium.stability import CLAMP_MOMENT, sliding_stiffness
from derod.equilibrium.system import System
from derod.rod.state import State


@dataclass(slots=True)
class Measured:
    """What a settled state and the linearisation there tell; in units of the rod's bending stiffness."""

    state: State
    arc_length: np.ndarray  # (N+1,) of the nodes, D
    energies: Energies
    reactions: Reactions
    settled: bool  # the residual meets the scene's tolerance
    residual: float  # the largest force, K/D^2
    turning: float  # radians, the largest turning angle at a node
    wall_gap: float  # D
    unstable_modes: int  # the drop held in its place along the rod
    sliding_stiffness: float  # k, K/D^3; inf without a drop
    clamp_moment: float  # the larger of the two clamps', K/D
    control_value: float  # of the control along which the slope is taken
    conjugate: float  # the potential's derivative by it
    slope_q: np.ndarray  # dq/dp along the branch
    slope_b: np.ndarray  # db/dp
    stiffness: float  # of the conjugate by the control, along the branch

    @property
    def energy(self) -> float:
        """Return the potential: E_tot and that of a dead load, K/D."""
        return self.energies.potential

    @property
    def energy_hat(self) -> float:
        """Return E_hat = E_tot + f_gamma (delta + 1), K/D."""
        state = self.state
        return self.energies.total + state.physics.capillary_force * (state.end_shortening + 1)

    @property
    def tension(self) -> float:
        """Return t, the axial force on the end clamp, K/D^2."""
        return float(self.reactions.end_force[2])

    @property
    def slides(self) -> bool:
        """Return whether sliding the drop along the rod is one more unstable mode."""
        return self.clamp_moment > CLAMP_MOMENT and self.sliding_stiffness < 0

    @property
    def released_modes(self) -> int:
        """Return the unstable modes, sliding among them."""
        return self.unstable_modes + self.slides


def measure(
    system: System, state: State, control: Control, tolerance: float | None = None
) -> Measured:
    """Measure a settled state, count its unstable modes and take its slope along the branch.

    ``tolerance`` (K/D^2) is what its residual is held to, the scene's if None. One gradient, one Hessian and
    its factor, one sum of energies.
    """
    count = system.linearise(state)
    if tolerance is None:
        tolerance = system.tolerance
    excess, residual, fall, gap, moment, terms = readings(
        state.physics, system.room, state.q, state.b, state.holonomy, tolerance
    )
    held = reactions(system, state)
    sliding = sliding_stiffness(system)
    column, column_border = control.column(system, state)
    solution, border = system.solve(column, column_border, refine=False)
    stiffness = control.own(system) - float(np.sum(column * solution) + column_border @ border)
    slope_q = np.zeros_like(state.q)
    slope_q[1:, : state.width] = solution
    slope_q[-1, system.dimension - 1] += control.moves_end()
    here = Measured(
        state=state,
        arc_length=system.measured_arc_length(),
        energies=by_part(terms),
        reactions=held,
        settled=excess <= 1,
        residual=residual,
        turning=math.acos(1 - fall),
        wall_gap=gap,
        unstable_modes=count,
        sliding_stiffness=sliding,
        clamp_moment=moment,
        control_value=control.value(state),
        conjugate=0.0,
        slope_q=slope_q,
        slope_b=border[: state.b.size],
        stiffness=stiffness,
    )
    here.conjugate = control.conjugate(here)
    return here
