"""Where on a branch it ends, or loses its stability: found between increments, not recorded.

At a fold of the control p the conjugate c has a square-root end: (dc/dp)^-2 falls to zero linearly in p. At
a bifurcation the lowest eigenvalue of the Hessian on the constraints crosses zero, linearly too.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from derod.equilibrium.measured import Measured
from derod.equilibrium.stability import lowest_mode
from derod.equilibrium.system import System

CLOSE = 1e-9  # of the control's usual step
LOOKS = 10  # states at most that are settled for one place
NEARER = 0.9  # of the way to a fold that one look goes

Trace = Callable[[Measured, Measured, float], Measured | None]
"""Settle on the branch of two states (the nearer first) at a value of the control; None if it fails."""


def fold(older: Measured, here: Measured, usual: float, trace: Trace) -> float | None:
    """Return the control's value at the fold ahead of two states on one branch; None if there is none."""
    place = None
    for _ in range(LOOKS):
        h = here.control_value - older.control_value
        before, now = older.stiffness**-2, here.stiffness**-2
        if h == 0 or not now < before:
            return place
        gap = now * h / (before - now)
        if place is not None and abs(gap) > abs(place - here.control_value) + abs(h):
            return place  # the law does not hold: it leads away
        place = here.control_value + gap
        if abs(gap) < CLOSE * usual:
            return place
        nearer = None
        for share in (NEARER, 0.5, 0.1):
            nearer = trace(here, older, here.control_value + share * gap)
            if nearer is not None:
                break
        if nearer is None or nearer.unstable_modes > here.unstable_modes:
            return place
        older, here = here, nearer
    return place


def crossing(
    system: System, stable: Measured, unstable: Measured, usual: float, trace: Trace
) -> float | None:
    """Return the control's value at which the lowest eigenvalue is zero, between two states of one branch."""
    start = np.random.default_rng(0).standard_normal(stable.state.q.shape)

    def lowest(here: Measured) -> float:
        return lowest_mode(system, here.state, start)[0]

    low, high = (stable, lowest(stable)), (unstable, lowest(unstable))
    if not low[1] > 0 > high[1]:
        return None
    place = None
    for _ in range(LOOKS):
        a, b = low[0].control_value, high[0].control_value
        before, place = place, a - low[1] * (b - a) / (high[1] - low[1])
        if before is not None and abs(place - before) < CLOSE * usual:
            return place
        near, far = (low, high) if abs(low[1]) < abs(high[1]) else (high, low)
        found = trace(near[0], far[0], place)
        if found is None:
            return place
        value = lowest(found)
        if not np.isfinite(value):
            return place
        if value > 0:
            low = (found, value)
        else:
            high = (found, value)
    return place
