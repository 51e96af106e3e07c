"""States of a rod with two bending stiffnesses from those of a round one: K2/K1 as a parameter.

At fixed end-shortening and capillary force K2/K1 is changed from 1, where states can be turned about the
clamp axis, to the rod's own. Of all turned states those stay flip-symmetric whose flip axis is a
principal axis of the section, d_2 or d_1, and which it is the clamps' directors say.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from derod.branches.half_rod import closure as col
from derod.branches.half_rod.mesh import adapted
from derod.branches.half_rod.mirror import Mirror
from derod.branches.half_rod.outcome import NotConverged
from derod.branches.half_rod.parameters import Parameters
from derod.branches.half_rod.state import HalfRod
from derod.branches.paths.arc import Control, frozen
from derod.branches.paths.newton import Settled, settle

FIXED = np.stack([frozen(col.FGAMMA), frozen(col.DELTA)])
"""Closing rows of a state at given f_gamma and delta."""
FIRST, LARGEST, LEAST = 0.05, 0.2, 1e-3
"""Steps of log(K2/K1)."""
FAR = 0.3
"""Largest change of any kept unknown of a node in a step: more could be another state."""
ITERATIONS = 12


def stiffened(state: HalfRod, parameters: Parameters, mirror: Mirror, control: Control) -> Settled:
    """The state of ``parameters`` that a round rod's state becomes as K2/K1 changes.

    Raises NotConverged where that state ends on the way, at a fold in K2/K1.
    """
    goal = math.log(parameters.bending_2)
    values = FIXED @ state.kept
    here, step = 0.0, FIRST
    out = settle(
        state.with_parameters(replace(parameters, bending_2=1.0)),
        mirror,
        FIXED,
        values,
        control.tolerance,
        ITERATIONS,
    )
    while here != goal:
        there = math.copysign(min(abs(goal), abs(here) + step), goal)
        ratio = parameters.bending_2 if there == goal else math.exp(there)
        found = _next(out, replace(parameters, bending_2=ratio), mirror, control)
        if found is None:
            step *= 0.5
            if step < LEAST:
                raise NotConverged(
                    f"K2/K1 could not be changed beyond {math.exp(here):.4g} at delta = "
                    f"{state.end_shortening:.5f}"
                )
            continue
        out, here, step = found, there, min(1.3 * step, LARGEST)
    return out


def _next(
    settled: Settled, parameters: Parameters, mirror: Mirror, control: Control
) -> Settled | None:
    """The state at another K2/K1, None where it is not found or too far."""
    before = settled.state
    try:
        start = adapted(before.with_parameters(parameters), control.resolution)
        found = settle(start, mirror, FIXED, FIXED @ before.kept, control.tolerance, ITERATIONS)
    except (NotConverged, np.linalg.LinAlgError):
        return None
    moved = np.abs(found.state.kept - before.kept)[: col.CX].max()
    return found if moved < FAR else None
