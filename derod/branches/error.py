"""Discretisation error of a settled state, by cutting every element in two."""

from __future__ import annotations

import numpy as np

from derod.branches.arc import Point, Tracer, frozen
from derod.branches.mesh import halved
from derod.branches.newton import settle
from derod.branches.observables import observables


def halving_error(tracer: Tracer, point: Point) -> float:
    """Largest change of t, E_hat (relative to themselves, or to one), wetted length and delta on the halved mesh.

    The state is solved again in the hyperplane across the path through the point, so that folds are
    no exception.
    """
    closing = np.stack([frozen(tracer.held), tracer.metric * point.tangent])
    values = closing @ point.state.kept
    fine = settle(
        halved(point.state), tracer.mirror, closing, values, tracer.control.tolerance, max_iterations=12
    )
    a, b = observables(point.state), observables(fine.state)
    return max(
        abs(a["end_tension"] - b["end_tension"]) / max(1.0, abs(b["end_tension"])),
        abs(a["energy_hat"] - b["energy_hat"]) / max(1.0, abs(b["energy_hat"])),
        abs(a["wetted_length"] - b["wetted_length"]),
        abs(a["end_shortening"] - b["end_shortening"]),
    )
