"""The states at one value of the control, by energy, and which saddles lie between which minima."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from derod.equilibrium.implicit import Implicit
from derod.equilibrium.loop import Outcome, relax
from derod.equilibrium.measured import measure
from derod.pushing.kicks import kick
from derod.rod.state import State
from derod.tracing.arc import Arc
from derod.tracing.path import Path
from derod.tracing.starting import Sheet, sheets
from derod.tracing.symmetry import SAME, distance, node_weights

KICK = 0.01  # D, off a saddle
DESCENTS = 6  # from one side of a saddle, each from where the one before met another


@dataclass(frozen=True, slots=True)
class Pass:
    """A saddle with one unstable mode, and the minima below its two sides, as places in a list of sheets."""

    saddle: int
    minima: tuple[int | None, int | None]  # None: a minimum that no path knows


def states_at(arc: Arc, paths: list[Path], value: float) -> list[Sheet]:
    """Return the states at a value of the control, each once up to the symmetries, by energy."""
    found = [sheet for path in paths for sheet in sheets(arc, path, value)]
    found.sort(key=lambda sheet: sheet.here.energy)
    out: list[Sheet] = []
    for sheet in found:
        if not any(same(arc, sheet.state, other.state) for other in out):
            out.append(sheet)
    return out


def same(arc: Arc, state: State, other: State) -> bool:
    """Return whether two states at one value of the control are one, up to the symmetries."""
    if abs(state.menisci[0] - other.menisci[0]) > 1e-3:
        return False
    weight = node_weights(arc.system.rest_lengths(state))
    return distance(state, other, weight) < 10 * SAME


def passes(arc: Arc, states: list[Sheet]) -> list[Pass]:
    """Return the saddles of index one among ``states`` and where descents from both of their sides end."""
    out = []
    for i, sheet in enumerate(states):
        if sheet.here.unstable_modes == 1:
            ends = [descend(arc, sheet.state, side) for side in (1.0, -1.0)]
            first, second = (placed(arc, states, end) for end in ends)
            out.append(Pass(i, (first, second)))
    return out


def placed(arc: Arc, states: list[Sheet], state: State | None) -> int | None:
    """Return which of the states this is."""
    if state is None:
        return None
    return next((k for k, one in enumerate(states) if same(arc, one.state, state)), None)


def descend(arc: Arc, saddle: State, side: float) -> State | None:
    """Return the minimum below one side of a saddle, None where none is reached."""
    system = arc.system
    state = saddle
    start = np.random.default_rng(0).standard_normal(state.q.shape)
    for _ in range(DESCENTS):
        off = kick(system, state, KICK, start, side)
        solution = relax(Implicit(), system, off.state, descend=True, kick=KICK)
        state = solution.state
        if solution.converged:
            if measure(system, state, arc.control).unstable_modes == 0:
                return state
        elif solution.outcome is not Outcome.SADDLE:
            return None
    return None
