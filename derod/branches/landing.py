"""States of a stored branch at a given end-shortening."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from derod.branches import closure as col
from derod.branches.arc import frozen
from derod.branches.fields import evaluate_fields, interpolate
from derod.branches.mirror import FULL, PLANES, Mirror
from derod.branches.newton import Settled, settle
from derod.branches.observables import observables
from derod.branches.outcome import NotConverged
from derod.branches.record import SCALED, StoredBranch
from derod.branches.state import HalfRod

TOLERANCE = 1e-10
LEAST_STEP = 1e-4
"""Shortest substep (D) on the way to an end-shortening."""
_BY_NAME = {m.name: m for pair in PLANES for m in pair} | {FULL.name: FULL}


@dataclass(frozen=True)
class Landing:
    """A branch's state at an end-shortening, and its numbers in units of K0."""

    branch: str
    state: HalfRod
    values: dict[str, float]


def sheets(branch: StoredBranch, delta: float) -> np.ndarray:
    """Indices i such that the branch passes ``delta`` between its points i and i + 1."""
    d = branch.table["end_shortening"]
    return np.flatnonzero((d[:-1] - delta) * (d[1:] - delta) <= 0.0)


def estimate(branch: StoredBranch, i: int, delta: float) -> tuple[float, float]:
    """Tension and E_hat at ``delta`` between points i and i + 1, linearly."""
    a, b = branch.table[i], branch.table[i + 1]
    span = b["end_shortening"] - a["end_shortening"]
    x = (delta - a["end_shortening"]) / span if span else 0.5
    out = [(1.0 - x) * a[name] + x * b[name] for name in ("end_tension", "energy_hat")]
    return float(out[0]), float(out[1])


def land(branch: StoredBranch, i: int, delta: float) -> Landing:
    """The branch's state at ``delta`` on the sheet between points i and i + 1.

    Raises NotConverged where neither point leads there.
    """
    mirror = _BY_NAME[branch.mirror]
    distance = np.abs(branch.table["end_shortening"][[i, i + 1]] - delta)
    failure: NotConverged | None = None
    for k in (i, i + 1) if distance[0] <= distance[1] else (i + 1, i):
        try:
            state = _walk(branch.state(k), mirror, delta).state
        except NotConverged as error:
            failure = error
            continue
        values = observables(state)
        for name in SCALED:
            values[name] *= branch.parameters.bending
        return Landing(branch.name, state, values)
    raise NotConverged(f"{branch.name} at delta = {delta:g}: {failure}")


def _walk(state: HalfRod, mirror: Mirror, delta: float) -> Settled:
    """Continue in delta from a stored state, the whole way at once or in halved steps."""
    closing = np.stack([frozen(col.FGAMMA), frozen(col.DELTA)])
    force = float(state.scalars[5])
    here = state.end_shortening
    settled = settle(state, mirror, closing, np.array([force, here]), TOLERANCE, 16)
    step = delta - here
    while settled.state.end_shortening != delta:
        here = settled.state.end_shortening
        step = float(np.clip(step, -abs(delta - here), abs(delta - here)))
        rate = settled.reduced.solve(closing, np.array([[0.0, 1.0, 0.0]]))[0]
        target = delta if abs(here + step - delta) < 1e-14 else here + step
        try:
            predicted = settled.state.moved(settled.reduced.expand(rate, 0.0), target - here)
            predicted = predicted.set_scalar(col.DELTA, target)
            if not evaluate_fields(predicted).gap > 0.0:
                raise NotConverged("the prediction lies outside the wall")
            settled = settle(predicted, mirror, closing, np.array([force, target]), TOLERANCE)
        except NotConverged:
            step *= 0.5
            if abs(step) < LEAST_STEP:
                raise
            continue
        if settled.state.end_shortening != target:  # delta is an unknown: solved, not copied
            settled = Settled(
                settled.state.set_scalar(col.DELTA, target), settled.reduced, settled.iterations
            )
        step *= 2.0
    return settled


def center_line(state: HalfRod, s: np.ndarray) -> np.ndarray:
    """Places (k, 3) of the whole rod at arc lengths ``s`` (k,) from the first clamp (at the
    origin), D."""
    half = 0.5 * state.parameters.length
    from_middle = np.asarray(s, dtype=float) - half
    nodes = np.delete(state.node_arc_length, state.inner + 1)
    distance = np.clip(np.abs(from_middle), 0.0, half)
    element = np.clip(np.searchsorted(nodes, distance, side="right") - 1, 0, state.eta.size - 1)
    at = (distance - nodes[element]) / state.lengths[element]
    r = interpolate(state, evaluate_fields(state), element, at)[:, :3]
    r[:, 1] -= state.nodes[-1, 1]
    r[from_middle < 0.0] *= np.array([-1.0, 1.0, -1.0])
    r[:, 2] += half - 0.5 * state.end_shortening
    return r
