"""A recorded state moved along one of its modes, and where it goes from there, downhill."""

from __future__ import annotations

from dataclasses import dataclass
from time import perf_counter
from typing import TYPE_CHECKING

import numpy as np

from derod.equilibrium.loop import Outcome, relax
from derod.equilibrium.measured import measure
from derod.equilibrium.methods import make_relaxer
from derod.equilibrium.turning import turns_freely
from derod.pushing.columns import Settled
from derod.pushing.controls import CONTROLS
from derod.pushing.encode import encode
from derod.pushing.frames import Frame
from derod.pushing.kicks import LEAST, onto_constraints
from derod.record.modes import Modes, ModesError, state_of
from derod.rod.state import State
from derod.rod.unknowns import S_A, S_B, X_C
from derod.scene.program import legs

if TYPE_CHECKING:
    from derod.record.run import BaseRun

SAME = (
    1e-6  # D, that nodes may be off in one and the same state, the turn about the axis left aside
)


@dataclass(frozen=True)
class Kicked:
    """Where a state went that was moved along a mode."""

    frame: Frame
    """The state it ended in, as recorded; its row's ``increment`` is the one it came from."""
    outcome: Outcome
    message: str
    amplitude: float
    """D, of the largest displacement, as it was possible: halved where the wall is nearer."""
    energy_before: float
    """The potential (E_tot, and that of a dead load) of the recorded state, K0/D."""
    energy_kicked: float
    """After the kick, on the constraints."""
    energy_after: float
    """Where it ended."""
    moved: float
    """D, how far nodes are from where they were, a free turn about the axis left aside."""

    @property
    def converged(self) -> bool:
        """Whether an equilibrium was found."""
        return self.outcome is Outcome.CONVERGED

    @property
    def came_back(self) -> bool:
        """Whether that is the state it came from."""
        return self.converged and self.moved < SAME

    def __repr__(self) -> str:
        count = int(self.frame.row["unstable_modes"])
        words = "stable" if count == 0 else f"{count} unstable modes"
        return (
            f"<kicked by {self.amplitude:.4g} D: {self.outcome}, moved {self.moved:.4g} D, "
            f"energy {self.energy_before:.8g} -> {self.energy_after:.8g} K0/D, {words}>"
        )


def kicked(run: BaseRun, i: int, modes: Modes, mode: int, amplitude: float) -> Kicked:
    """Move increment ``i`` along ``modes`` number ``mode`` (from 0) and relax it downhill.

    ``amplitude`` (D, either sign) is the largest displacement of a node. The relaxation only goes down; what
    it ends in may be a saddle where a symmetry holds it there: its row's ``unstable_modes`` tells.
    """
    if not 0 <= mode < len(modes):
        raise ModesError(f"mode = {mode}: allowed: 0 to {len(modes) - 1}")
    if not LEAST <= abs(amplitude) <= run.scene.rod.length:
        raise ModesError(f"amplitude = {amplitude:g}: allowed: {LEAST:g} to the rod's length, in D")
    clock = perf_counter()
    system, state = state_of(run, i)
    system.gradient(state)
    unit, before, gap = system.bending, system.energies(state).potential, system.wall_gap(state)
    raised = 2 * abs(float(modes.eigenvalues[mode])) / unit
    while True:
        start = displaced(state, modes, mode, amplitude)
        if onto_constraints(system, start, gap, raised):
            break
        amplitude *= 0.5
        if abs(amplitude) < LEAST:
            raise ModesError(f"increment {i}: no kick along mode {mode} leaves the rod in the drop")
    pushed = system.energies(start).potential
    solution = relax(make_relaxer("implicit"), system, start, descend=True)
    sliding = solution.state.physics.slides
    control = CONTROLS["end_tension" if sliding else "end_shortening"]
    here = measure(system, solution.state, control)
    row = run.table[i]
    segment = int(row["segment"])
    leg = legs(run.scene)[segment]
    told = Settled(
        i, segment, False, False, here.residual, np.nan, solution.iterations,
        float(leg.max_step), perf_counter() - clock,
    )  # fmt: skip
    return Kicked(
        encode(system, here, told), solution.outcome, solution.message, amplitude, before * unit,
        pushed * unit, here.energy * unit, distance(state, here.state),
    )  # fmt: skip


def displaced(state: State, modes: Modes, mode: int, amplitude: float) -> State:
    """Return the state moved along a mode."""
    d = state.dimension
    moved = state.copy()
    moved.q[:, :d] += amplitude * modes.shapes[mode][:, 3 - d :]
    moved.b[[S_A, S_B]] += amplitude * modes.menisci[mode]
    moved.b[X_C : X_C + d] += amplitude * modes.drop[mode][3 - d :]
    return moved


def distance(one: State, other: State) -> float:
    """Return the largest distance of nodes of two states, D.

    Where turning about the axis is free, after the turn that fits best.
    """
    x, y = one.positions, other.positions
    a, b = x[:, 0] + 1j * x[:, 1], y[:, 0] + 1j * y[:, 1]
    angle = float(np.angle(np.vdot(b, a))) if turns_freely(one) else 0.0
    turned = b * np.exp(1j * angle)
    return float(np.hypot(abs(a - turned), abs(x[:, 2] - y[:, 2])).max())
