"""What the implicit steps, along a branch and downhill, have in common."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

ACCEPTED, STALLED, STRAYED, UNSOUND = 0, 1, 2, 3  # what became of a step, or of a beginning
PLAIN, REFINED = 0, 1  # Newton's step, solved for plainly or with a step of refinement
CHORD = 2  # a step with the last factor


class Rules(NamedTuple):
    """What a step must keep to."""

    tolerance: float  # K0/D^2, of the residual force
    descend: bool  # downhill, to a minimum; else along the branch
    kick: float  # D, the kick that would leave a saddle met on the way down


class Work(NamedTuple):
    """Arrays a step works in."""

    origin: np.ndarray  # (N+1, d+1) q as it was predicted
    dq: np.ndarray  # (N+1, d+1) the step
    db: np.ndarray  # (d+5,)
    tq: np.ndarray  # (N+1, d+1) the trial state
    tb: np.ndarray  # (d+5,)


def new_work(q: np.ndarray, b: np.ndarray) -> Work:
    """Return arrays for steps from the predicted state (q, b)."""
    return Work(q.copy(), np.zeros_like(q), np.zeros_like(b), np.zeros_like(q), np.zeros_like(b))
