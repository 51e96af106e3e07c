"""Where paths begin: a slightly buckled rod, and with a weight a buckled one that was loaded."""

from __future__ import annotations

import math

from derod.branches.half_rod import closure as col
from derod.branches.half_rod.mirror import Mirror
from derod.branches.half_rod.outcome import NotConverged
from derod.branches.half_rod.parameters import Parameters
from derod.branches.paths.arc import Control, Point, Tracer, frozen
from derod.branches.paths.newton import Settled
from derod.branches.paths.path import PathNotFound
from derod.branches.paths.straight import buckling_tensions, first_buckled
from derod.branches.paths.tracing import collect, end_reason
from derod.branches.paths.weight import hung, loaded

AMPLITUDE = 0.02
"""Lateral offset (D) or quaternion component held in the first buckled state."""
START = (0.25 * math.pi, 0.5 * math.pi, 0.1 * math.pi, 1.0 * math.pi)
"""End-shortenings (D) at which the first buckled path is loaded, tried in turn."""


def first_point(
    tracer: Tracer, parameters: Parameters, tension: float, mode: Mirror, held: int
) -> Point:
    """The first point of a path that leaves the straight rod at a buckling tension (K0/D^2).

    ``mode``: the class it buckles in; the kept unknown ``held`` is AMPLITUDE there.
    """
    control = tracer.control
    settled = first_buckled(
        parameters,
        tension,
        mode,
        tracer.mirror,
        held,
        AMPLITUDE,
        control.tolerance,
        control.resolution,
    )
    return tracer.begin(settled, frozen(held))


def buckled(
    parameters: Parameters, control: Control, mode: Mirror, mirror: Mirror
) -> tuple[Tracer, Point, float]:
    """The first point of the path that leaves the straight rod first, and the buckling tension."""
    tension = buckling_tensions(parameters, mode)[0]
    tracer = Tracer(mirror, control, parameters.capillary_force)
    return tracer, first_point(tracer, parameters, tension, mode, col.NODE_0 + 1), tension


def loaded_start(
    parameters: Parameters, control: Control, mode: Mirror, mirror: Mirror, *, upside_down: bool
) -> Settled:
    """A state of the heavy drop, on the path that starts as the straight rod's buckling.

    Raises PathNotFound where the weight cannot be raised at any end-shortening tried.
    """
    tracer, start, _ = buckled(parameters, control, mode, mirror)
    missed = []
    for delta in START:
        goal = min(delta, 0.5 * (parameters.length - 1.0))
        points, _ = collect(tracer, start, end_reason(goal))
        state = hung(points[-1].state, start.state, upside_down=upside_down)
        try:
            return loaded(state, parameters.weight, mirror, control)[0]
        except NotConverged as error:
            missed.append(str(error))
    raise PathNotFound("; ".join(missed))
