"""The path of what the round rod's 3D becomes as K2/K1 changes: 3D-K2.

With stiffnesses far apart 3D leaves Ax subcritically and soon ends, and what a rod that has left Ax comes to
lies on a path that no pitchfork of Ax leads to.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection

import numpy as np

from derod.branches.half_rod.mirror import FULL, PLANES
from derod.branches.half_rod.observables import observables
from derod.branches.half_rod.outcome import NotConverged
from derod.branches.half_rod.parameters import Parameters
from derod.branches.half_rod.state import HalfRod
from derod.branches.paths.arc import Point, Tracer
from derod.branches.paths.joints import odd_part, stop_in_plane
from derod.branches.paths.path import Path, PathNotFound
from derod.branches.paths.stiffening import stiffened
from derod.branches.paths.tracing import two_ways

NAME = "3D-K2"
PLACES = (1.0 * math.pi, 0.75 * math.pi, 0.5 * math.pi, 1.5 * math.pi, 0.35 * math.pi)
"""End-shortenings (D) at which K2/K1 is changed, tried in turn."""
FLAT = 1e-4
"""A state is planar if no unknown out of the plane is larger."""
SAME = 1e-6
"""States are one if t and E_hat are this near (relative, or to 1)."""
STRAIGHT = 0.01
"""A path is left where its end-shortening falls below this (D): the straight rod is near."""


def stiffened_path(
    origin: Path,
    parameters: Parameters,
    tracer: Tracer,
    known: Collection[Path],
    delta_limit: float,
) -> tuple[Path, object] | None:
    """The path and what its stop test said at its end of growing delta; None where a ``known`` one has it.

    ``origin``: 3D of the round rod; ``tracer`` is the new path's.

    Raises PathNotFound where the round rod's 3D cannot be followed to this K2/K1 at any of PLACES.
    """
    for delta in PLACES:
        for state in origin.landings(delta):
            try:
                settled = stiffened(state, parameters, FULL, tracer.control)
            except NotConverged:
                continue
            if _flat(settled.state):
                continue  # the space states end in a plane on the way
            if any(_same(settled.state, x) for path in known for x in path.landings(delta)):
                return None
            remarks: list[str] = []
            ahead, behind = stop_in_plane(delta_limit), _stop(delta_limit)
            found = two_ways(tracer, settled, None, remarks, ahead, behind)
            path = Path(
                NAME, tracer, None, found.points, found.specials, found.begins, remarks=remarks
            )
            if isinstance(found.ends, str):
                path.ends = found.ends
            return path, found.ends
    raise PathNotFound("the round rod's 3D could not be followed to this K2/K1")


def _stop(delta_limit: float) -> Callable[[Point], str | None]:
    """The stop test toward small end-shortenings."""
    usual = stop_in_plane(delta_limit)

    def stop(point: Point) -> str | None:
        found = usual(point)
        if found is None and point.state.end_shortening < STRAIGHT:
            return "nearly straight"
        return found if found is None or isinstance(found, str) else "met a plane"

    return stop


def _flat(state: HalfRod) -> bool:
    return any(np.abs(odd_part(state, odd)).max() < FLAT for _, odd in PLANES)


def _same(one: HalfRod, other: HalfRod) -> bool:
    a, b = observables(one), observables(other)
    return all(
        abs(a[name] - b[name]) < SAME * max(1.0, abs(b[name]))
        for name in ("end_tension", "energy_hat")
    )
