"""The turn of the rod about the clamp axis: whether it costs energy, and its displacement."""

from __future__ import annotations

import numpy as np

from derod.rod.state import State
from derod.rod.terms import TERMS
from derod.rod.unknowns import X_C

LEAST_TURNING = 1e-10  # D^1.5, of its size in a metric; below it the rod lies on the axis


def turns_freely(state: State) -> bool:
    """Return whether turning the rod about the clamp axis costs nothing (``rod.assembly``, for kernels)."""
    broken = (term.breaks_turn for term in TERMS)
    return state.dimension == 3 and not any(
        getattr(state.physics, name) != 0.0 for name in broken if name
    )


def turning(state: State, border_size: int) -> tuple[np.ndarray, np.ndarray]:
    """Return the displacement of a turn, e_z x r, as rows of q and the border; zero in the plane."""
    rows, border = np.zeros((len(state.q) - 1, state.width)), np.zeros(border_size)
    if state.dimension == 3:
        rows[:, 0], rows[:, 1] = -state.q[1:, 1], state.q[1:, 0]
        border[X_C], border[X_C + 1] = -state.b[X_C + 1], state.b[X_C]
    return rows, border
