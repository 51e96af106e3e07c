"""States of a stored branch at a given end-shortening, on all its sheets."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.optimize import brentq

from derod.branches.half_rod import closure as col
from derod.branches.half_rod.linear import Reduced, linearise
from derod.branches.half_rod.mesh import RESOLUTION, adapted, halved
from derod.branches.half_rod.mirror import FULL
from derod.branches.half_rod.observables import SCALED, observables
from derod.branches.half_rod.outcome import NotConverged
from derod.branches.half_rod.state import HalfRod
from derod.branches.half_rod.threads import one_blas_thread
from derod.branches.paths.interval import TOLERANCE, Interval, Place, solved
from derod.branches.paths.newton import settle
from derod.branches.paths.stability import Stability, stability
from derod.branches.paths.tabulated import Tabulated
from derod.errors import DerodError

ACCURACY = 1e-8
"""Estimated error of t and E_hat at which a landing's mesh is fine enough."""
REFINEMENTS = (1.4, 2.0, 2.8)
SAMPLES = (0.25, 0.5, 0.75, 0.9, 0.97)
"""Shares of an interval at which a fold is looked for where one may be hidden."""
JOINT_SHIFT = 2e-8
"""D: where a joint lies changes by up to 6e-9 from mesh to mesh; nearer to it than this a space
path's landing is the joint, in its plane."""
ON_POINT = 1e-12
"""End-shortenings (D) this near to a stored point's are that point's."""


class LandingError(DerodError):
    """A branch has no state at an end-shortening, or it could not be solved."""


@dataclass(frozen=True)
class Landing:
    """A branch's solved state at an end-shortening.

    ``values``: the columns of ``files.layout.POINT`` that ``observables`` gives, in D and K0. ``interval``
    i: the state lies between the branch's points i and i + 1, ``share`` of the way (a state is at
    its point where share = 0). ``tension_error``, ``energy_error``: estimated errors of t and E_hat
    at this end-shortening from halved elements, relative to them, or to one where they are smaller;
    at a fold, where t has a vertical tangent, that of t grows like a square root.
    """

    branch: str
    interval: int
    share: float
    state: HalfRod
    values: dict[str, float]
    tension_error: float
    energy_error: float
    special: bool = False  # a fold or a pitchfork: a flip-even mode is neutral
    beside: bool = False  # the interval ends at one: a mode is soft

    @cached_property
    def stability(self) -> Stability:
        """Unstable modes, flip-even and flip-odd, and whether the drop slides."""
        state = halved(self.state) if self.beside else self.state
        return stability(state, critical=self.special)

    @property
    def unstable_modes(self) -> tuple[int, int]:
        """Numbers of unstable flip-even and flip-odd modes, sliding among the latter."""
        return self.stability.even, self.stability.odd + self.stability.slides


@one_blas_thread
def states_at(branch: Tabulated, delta: float) -> tuple[Landing, ...]:
    """The branch's states at end-shortening ``delta`` (D), in the order of its points.

    Raises LandingError where the branch has none, and where one cannot be solved.
    """
    out: list[Landing] = []
    for i in intervals(branch, delta):
        try:
            out.extend(landings(branch, i, delta))
        except NotConverged as error:
            raise LandingError(f"{branch.name} at delta = {delta:.9g}: {error}") from error
    if not out:
        d = branch.table["end_shortening"]
        raise LandingError(
            f"{branch.name} has no state at delta = {delta:.9g}; allowed: {d.min():.9g} to "
            f"{d.max():.9g}"
        )
    return tuple(out)


def intervals(branch: Tabulated, delta: float) -> list[int]:
    """Indices i of the intervals (points i to i + 1) in which the branch may pass ``delta``.

    Those that end on both sides of it, and those where a fold that is no stored point may lie: beside
    a joint, and where the stored end-shortenings turn at a point that is no fold.
    """
    d = branch.table["end_shortening"] - delta
    passed = (d[:-1] * d[1:] <= 0.0) | (np.minimum(abs(d[:-1]), abs(d[1:])) < ON_POINT)
    for i in (0, d.size - 2):
        passed[i] |= _at(branch, i, delta) or _at(branch, i + 1, delta)
    reach = np.minimum(abs(d[:-1]), abs(d[1:])) <= np.abs(np.diff(d))
    return [int(i) for i in np.flatnonzero(passed | (reach & _hidden(branch)))]


def _hidden(branch: Tabulated) -> np.ndarray:
    """Whether each interval (n - 1,) may hold a fold that is no stored point."""
    steps = np.diff(branch.table["end_shortening"])
    out = np.zeros(steps.size, dtype=bool)
    out[[0, -1]] = True
    special = set(branch.bifurcations["index"].tolist())
    for i in np.flatnonzero(steps[:-1] * steps[1:] <= 0.0) + 1:
        if int(i) not in special:
            out[[i - 1, i]] = True
    return out


def landings(branch: Tabulated, i: int, delta: float) -> list[Landing]:
    """The states at ``delta`` between points i and i + 1: none, one, or two beside a fold.

    A state on point i + 1 belongs to the next interval, but for the last. Raises NotConverged.
    """
    if _at(branch, i, delta):
        return [_on_point(branch, i, i, delta)]
    if _at(branch, i + 1, delta):
        return [_on_point(branch, i, i + 1, delta)] if i + 2 == len(branch) else []
    interval = Interval(branch, i, delta)
    found = [
        _landing(interval, x, delta) for x in _roots(interval, delta, bool(_hidden(branch)[i]))
    ]
    return found if interval.sense > 0 else found[::-1]


def _at(branch: Tabulated, point: int, delta: float) -> bool:
    """Whether ``delta`` is that of a stored point.

    Beside a joint no mesh tells the space curve from the planar one within JOINT_SHIFT.
    """
    joint = branch.mirror == FULL.name and point in (0, len(branch) - 1)
    joint = joint and point in branch.bifurcations["index"]
    nearest = JOINT_SHIFT if joint else ON_POINT
    return bool(abs(branch.table["end_shortening"][point] - delta) < nearest)


def _on_point(branch: Tabulated, interval: int, point: int, delta: float) -> Landing:
    """The landing on a stored point; what ``delta`` is off the point's is in the errors."""
    settled = solved(branch, point)
    a, b = branch.table[point], branch.table[point - 1 if point > interval else point + 1]
    off = abs(delta - a["end_shortening"])
    span = max(abs(b["end_shortening"] - a["end_shortening"]), off)
    slope = abs(b["end_tension"] - a["end_tension"]) / span if span else 0.0
    force = float(settled.state.scalars[5]) * branch.parameters.bending
    tension = float(a["error"] + off * slope / max(1.0, abs(a["end_tension"])))
    energy = float(
        a["error"] + off * abs(force - a["end_tension"]) / max(1.0, abs(a["energy_hat"]))
    )
    state = settled.state.set_scalar(col.DELTA, delta)
    special = bool(point in branch.bifurcations["index"])
    values = _values(branch, state)
    share = float(point - interval)
    return Landing(branch.name, interval, share, state, values, tension, energy, special)


def _values(branch: Tabulated, state: HalfRod) -> dict[str, float]:
    values = observables(state)
    for name in SCALED:
        values[name] *= branch.parameters.bending
    return values


def _roots(interval: Interval, delta: float, hidden: bool) -> list[float]:
    """The projections x at which the interval passes ``delta``, in growing order."""

    def off(x: float) -> float:
        if x in (0.0, interval.length):  # as stored, so that no state falls between two intervals
            return float(interval.ends["end_shortening"][int(x > 0.0)]) - delta
        return interval.at(x).state.end_shortening - delta

    knots = [0.0]
    if hidden:  # as far as the interval can be followed; a root beyond is asked for below
        slopes = [interval.at(0.0).slope]
        for share in SAMPLES:
            try:
                slopes.append(interval.at(share * interval.length).slope)
            except NotConverged:
                break
            knots.append(share * interval.length)
        for a, b, left, right in zip(knots[:-1], knots[1:], slopes[:-1], slopes[1:], strict=True):
            if left * right < 0.0:
                turn = brentq(lambda x: interval.at(x).slope, a, b, xtol=1e-12 * interval.length)
                knots.append(float(turn))
        knots.sort()
    knots.append(interval.length)
    values = [off(x) for x in knots]
    out = []
    for a, b, left, right in zip(knots[:-1], knots[1:], values[:-1], values[1:], strict=True):
        if left * right < 0.0:
            out.append(float(brentq(off, a, b, xtol=1e-15 * interval.length, rtol=1e-15)))
        elif left == 0.0:
            out.append(a)
    return out


def _landing(interval: Interval, x: float, delta: float) -> Landing:
    """The landing at a root, on a mesh fine enough for ACCURACY where one can be solved."""
    place = interval.at(x)
    errors = _errors(interval, place, delta)
    for factor in REFINEMENTS:
        if max(errors) <= ACCURACY:
            break
        try:
            finer = _refined(interval, place, factor, delta)
            own = _errors(interval, finer, delta)
        except NotConverged:
            continue
        if max(own) < max(errors):
            place, errors = finer, own
    state = place.state.set_scalar(col.DELTA, delta)
    interval.check_energy(state)
    share = place.x / interval.length
    if interval.sense < 0:
        share = 1.0 - share
    branch, i = interval.branch, interval.index
    beside = bool({i, i + 1} & set(branch.bifurcations["index"].tolist()))
    return Landing(
        branch.name, i, share, state, _values(branch, state), *errors, special=False, beside=beside
    )


def _refined(interval: Interval, place: Place, factor: float, delta: float) -> Place:
    """The state on a finer mesh, moved back to ``delta``."""
    finer = interval.solve(adapted(place.state, factor * RESOLUTION), place.x)
    for _ in range(2):
        step = (delta - finer.state.end_shortening) / finer.slope
        if not abs(step) < 1e-3 * interval.length:
            break  # at a fold; what is missing is in the estimated error
        increment = finer.settled.reduced.expand(finer.rate, 0.0)
        finer = interval.solve(finer.state.moved(increment, step), finer.x + step)
    interval.check(finer)
    return finer


def _errors(interval: Interval, place: Place, delta: float) -> tuple[float, float]:
    """Estimated errors of t and E_hat at ``delta``: the same state with every element cut in two.

    Both are taken at the same projection x; the change of delta is turned into one of t by the
    path's slope, or, near a fold, by its curvature, and into one of E_hat by f_gamma - t.
    """
    start = halved(place.state)
    values = interval.values(place.x)
    reduced = Reduced(linearise(start), interval.mirror)
    missing = values - interval.closing @ start.kept
    kept = reduced.solve(interval.closing, np.array([[*missing, 1.0]]))[0]
    step = reduced.expand(kept, 1.0)
    fine = start.moved(step)
    if step.size > 1e-5:  # a Newton step leaves an error of its square
        fine = settle(start, interval.mirror, interval.closing, values, TOLERANCE, 16).state
    a, b = observables(place.state), observables(fine)
    shift = delta - b["end_shortening"]
    with np.errstate(divide="ignore", invalid="ignore"):
        curvature = (place.slope - interval.known[0].slope) / place.x if place.x else 0.0
        moved = min(
            abs(np.divide(shift, place.slope)), np.sqrt(abs(np.divide(2.0 * shift, curvature)))
        )
    if shift == 0.0:
        moved = 0.0
    by_x = float(place.rate[col.NODE_END + 9])
    change = b["end_tension"] - a["end_tension"]
    if np.isfinite(moved):
        change += by_x * np.copysign(moved, shift * place.slope)
    energy = b["energy_hat"] - a["energy_hat"] + (interval.force - a["end_tension"]) * shift
    return (
        float(abs(change)) / max(1.0, abs(a["end_tension"])),
        float(abs(energy)) / max(1.0, abs(a["energy_hat"])),
    )
