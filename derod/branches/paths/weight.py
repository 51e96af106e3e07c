"""States of a heavy drop from those of a weightless one: the weight as a path's parameter.

At fixed end-shortening and capillary force the weight W is raised from 0 by pseudo-arclength, so
that folds in W are no exception. Weightless states can be turned about the clamp axis; of all turned
ones those whose flip axis e_y is vertical stay flip-symmetric, and there are two: as the state is, and
turned by pi about e_z. *Hanging* is the one whose drop is below the clamp axis where its path begins
(y_C < 0), *upside down* the other one. Later on a path y_C may have either sign.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from itertools import pairwise

import numpy as np

from derod.branches.half_rod import closure as col
from derod.branches.half_rod.mirror import Mirror
from derod.branches.half_rod.outcome import NotConverged
from derod.branches.half_rod.state import HalfRod
from derod.branches.half_rod.symmetry import half_turned
from derod.branches.paths.arc import Control, Point, Tracer, frozen
from derod.branches.paths.newton import Settled, settle
from derod.branches.paths.tracing import collect

FIXED = np.stack([frozen(col.DELTA), frozen(col.FGAMMA), frozen(col.WEIGHT)])
"""Closing rows of a state at given delta, f_gamma and W."""
BEYOND = 2.0
"""A path in the weight is left at this multiple of the weight wanted, and at minus that weight."""
POINTS = 300
"""Most points of a path in the weight."""


def hung(state: HalfRod, start: HalfRod, *, upside_down: bool = False) -> HalfRod:
    """A weightless state, turned by pi about the clamp axis where its path's ``start`` has its drop on
    the wrong side."""
    above = start.nodes[-1, 1] < 0.0  # w_y(l/2) = -y_C
    return state if above == upside_down else half_turned(state)


def loaded(
    state: HalfRod, weight: float, mirror: Mirror, control: Control, *, first: bool = True
) -> list[Settled]:
    """The states of weight W (K0/D^2) on the path in W from a weightless state, delta and f_gamma kept.

    The ``first`` only, or all that the path meets until it leaves -W to BEYOND W: sheets of the
    solution set at this end-shortening. Raises NotConverged where the path does not reach W.
    """
    force = float(state.scalars[5])
    tracer = Tracer(mirror, control, force, (col.DELTA, col.FGAMMA))
    start = settle(state, mirror, FIXED, FIXED @ state.kept, control.tolerance, 20)
    stop = _passed(weight, first)
    upward = math.copysign(1.0, weight) * frozen(col.WEIGHT)
    points, reason = collect(tracer, tracer.begin(start, upward), stop)
    out = []
    for left, right in pairwise(points):
        a, b = left.state.weight - weight, right.state.weight - weight
        if a * b <= 0.0 and a != 0.0:
            out.append(_between(tracer, left, right, weight))
    if not out:
        raise NotConverged(
            f"the weight could not be raised to {weight:g} at delta = "
            f"{state.end_shortening:.5f} ({reason})"
        )
    return out


def _passed(weight: float, first: bool) -> Callable[[Point], str | None]:
    count = 0

    def stop(point: Point) -> str | None:
        nonlocal count
        count += 1
        share = point.state.weight / weight
        if first and share >= 1.0:
            return "there"
        if not -1.0 <= share <= BEYOND:
            return f"W = {point.state.weight:g}"
        return f"more than {POINTS} points" if count > POINTS else None

    return stop


def _between(tracer: Tracer, left: Point, right: Point, weight: float) -> Settled:
    """The state of weight W between two successive points of a path in the weight."""
    share = (weight - left.state.weight) / (right.state.weight - left.state.weight)
    guess = tracer.advance(left, share * (right.arc - left.arc)).state
    values = np.array([guess.end_shortening, guess.scalars[5], weight])
    values[:2] = left.state.scalars[4:6]
    return settle(guess, tracer.mirror, FIXED, values, tracer.control.tolerance, 20)
