"""Discretisation error of a settled state, by cutting every element in two."""

from __future__ import annotations

import numpy as np

from derod.branches.half_rod.linear import Reduced, linearise
from derod.branches.half_rod.mesh import adapted, halved
from derod.branches.half_rod.observables import observables
from derod.branches.half_rod.outcome import NotConverged
from derod.branches.half_rod.state import HalfRod
from derod.branches.paths.arc import Point, Tracer
from derod.branches.paths.newton import settle

ONE_STEP = 1e-5
"""A Newton step this small leaves an error of its square, far below what is measured."""
REFINEMENTS = (1.0, 1.4, 2.0, 2.8)
"""Resolutions tried, relative to the path's own, until a point is accurate enough."""


def halving_error(tracer: Tracer, state: HalfRod, tangent: np.ndarray) -> float:
    """Largest change of t, E_hat (relative to themselves, or to one), wetted length and delta on
    the halved mesh.

    The state is solved again in the hyperplane across the path (normal ``tangent``), so that
    folds are no exception. Raises NotConverged.
    """
    closing = tracer.closing(tangent)
    values = closing @ state.kept
    a, b = observables(state), observables(_on_halved_mesh(tracer, state, closing, values))
    return max(
        abs(a["end_tension"] - b["end_tension"]) / max(1.0, abs(b["end_tension"])),
        abs(a["energy_hat"] - b["energy_hat"]) / max(1.0, abs(b["energy_hat"])),
        abs(a["wetted_length"] - b["wetted_length"]),
        abs(a["end_shortening"] - b["end_shortening"]),
    )


def _on_halved_mesh(
    tracer: Tracer, state: HalfRod, closing: np.ndarray, values: np.ndarray
) -> HalfRod:
    """The state solved on the halved mesh: one Newton step where that is enough (it squares the
    error)."""
    start = halved(state)
    reduced = Reduced(linearise(start), tracer.mirror)
    missing = values - closing @ start.kept
    step = reduced.expand(reduced.solve(closing, np.array([[*missing, 1.0]]))[0], 1.0)
    if step.size < ONE_STEP:
        return start.moved(step)
    return settle(start, tracer.mirror, closing, values, tracer.control.tolerance, 16).state


def refined(tracer: Tracer, point: Point) -> tuple[HalfRod, float]:
    """The point's state on a mesh fine enough for ``control.accuracy``, and its halving error.

    The error is nan where no refinement could be solved.
    """
    closing = tracer.closing(point.tangent)
    values = closing @ point.state.kept
    state, best, error = point.state, point.state, np.inf
    for factor in REFINEMENTS:
        try:
            if factor > 1.0:
                finer = adapted(point.state, factor * tracer.control.resolution)
                state = settle(
                    finer, tracer.mirror, closing, values, tracer.control.tolerance, 16
                ).state
            own = halving_error(tracer, state, point.tangent)
        except NotConverged:
            continue
        if own < error:
            best, error = state, own
        if error <= tracer.control.accuracy:
            break
    return best, float(error) if np.isfinite(error) else float("nan")
