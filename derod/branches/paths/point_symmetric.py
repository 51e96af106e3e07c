"""A state of the point-symmetric planar curve Pt: buckled in a stronger liquid, and brought back.

At the scene's f_gamma Pt need not be connected with the straight rod. With a larger one the second
mode buckles; on its path f_gamma is lowered at fixed end-shortening.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from derod.branches.half_rod import closure as col
from derod.branches.half_rod.mirror import S_EVEN, STRAIGHT_S
from derod.branches.half_rod.parameters import Parameters
from derod.branches.paths.arc import Control, Tracer, frozen
from derod.branches.paths.beginning import first_point
from derod.branches.paths.newton import Settled, settle
from derod.branches.paths.path import PathNotFound
from derod.branches.paths.straight import NoBuckling, buckling_tensions
from derod.branches.paths.tracing import collect, end_reason

END_SHORTENING = 1.1 * math.pi
"""Where f_gamma is lowered (D)."""
FACTORS = (1.0, 1.5, 2.0, 3.0, 4.0, 6.0, 8.0, 12.0)
"""Multiples of f_gamma, times the stiffness about e_y over K1, at which the second mode is looked for."""


def point_symmetric_state(parameters: Parameters, control: Control) -> Settled:
    """A state of Pt at END_SHORTENING. Raises PathNotFound, NotConverged."""
    target = parameters.capillary_force
    strong, tension = _second_mode(parameters)
    held = col.NODE_0 + 5
    tracer = Tracer(S_EVEN, control, target)
    goal = min(END_SHORTENING, 0.5 * (parameters.length - 1.0))
    points, _ = collect(
        tracer,
        first_point(tracer, strong, tension, STRAIGHT_S, held),
        lambda p: "there" if p.state.end_shortening > goal else end_reason(goal)(p),
    )
    if points[-1].state.end_shortening <= goal:
        raise PathNotFound("Pt: the second mode's path does not reach the end-shortening wanted")
    lowering = Tracer(S_EVEN, control, target, (col.DELTA,))
    points, _ = collect(
        lowering,
        lowering.begin(points[-1].settled, -frozen(col.FGAMMA)),
        lambda p: "there" if p.state.scalars[5] <= target else None,
    )
    if points[-1].state.scalars[5] > target:
        raise PathNotFound("Pt: f_gamma could not be lowered to the scene's")
    state = points[-1].state.set_scalar(col.FGAMMA, target)
    closing = np.stack([frozen(col.FGAMMA), frozen(col.DELTA)])
    values = np.array([target, state.end_shortening])
    state = replace(state, parameters=parameters)
    return settle(state, S_EVEN, closing, values, control.tolerance, 20)


def _second_mode(parameters: Parameters) -> tuple[Parameters, float]:
    """The rod in the weakest liquid tried in which its second mode buckles, and the tension there."""
    stiffness = float(parameters.section[2])
    for factor in FACTORS:
        strong = parameters.with_capillary_force(factor * stiffness * parameters.capillary_force)
        try:
            return strong, buckling_tensions(strong, STRAIGHT_S)[0]
        except NoBuckling:
            continue
    raise PathNotFound("Pt: the straight rod's second mode does not buckle at any f_gamma tried")
