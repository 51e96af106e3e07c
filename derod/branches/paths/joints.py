"""Where a space path meets a plane: the crossing, the planar state there, and its pitchfork."""

from __future__ import annotations

from collections.abc import Callable, Iterable

import numpy as np

from derod.branches.half_rod import closure as col
from derod.branches.half_rod.mirror import Mirror, planes
from derod.branches.half_rod.state import HalfRod
from derod.branches.paths.arc import Point, frozen
from derod.branches.paths.newton import Settled, settle
from derod.branches.paths.path import Path
from derod.branches.paths.special import SpecialPoint
from derod.branches.paths.tracing import end_reason

JOINT_DISTANCE = 0.1
"""A plane met is one already traced if (delta, t/f_gamma, sigma) are this near to its pitchfork."""


def odd_part(state: HalfRod, odd: Mirror) -> np.ndarray:
    """The kept unknowns that vanish on planar states of this class."""
    return state.kept[odd.kept]


def crossed_plane(before: HalfRod, after: HalfRod) -> tuple[Mirror, Mirror] | None:
    """The (even, odd) class of planar states between two successive space states, if there is one.

    Through a pitchfork all out-of-plane unknowns change sign together.
    """
    for even, odd in planes(before.weight):
        a, b = odd_part(before, odd), odd_part(after, odd)
        if a @ b < -0.7 * np.linalg.norm(a) * np.linalg.norm(b):
            return even, odd
    return None


def flattened(state: HalfRod, even: Mirror, tolerance: float) -> Settled:
    """The planar state at the end-shortening of a nearly planar one."""
    nodes, stages = np.zeros_like(state.nodes), np.zeros_like(state.stages)
    nodes[:, even.states] = state.nodes[:, even.states]
    turns = even.states[(even.states >= 3) & (even.states < 7)]
    stages[:, :, turns - 3] = state.stages[:, :, turns - 3]
    scalars = np.zeros_like(state.scalars)
    held = np.concatenate([even.parameters - 10, [4, 5, 6]])
    scalars[held] = state.scalars[held]
    flat = HalfRod(state.parameters, state.eta, state.inner, nodes, stages, scalars)
    closing = np.stack([frozen(col.FGAMMA), frozen(col.DELTA)])
    return settle(flat, even, closing, scalars[[5, 4]], tolerance, max_iterations=20)


def stop_in_plane(delta_limit: float) -> Callable[[Point], object]:
    """Stop where a space path crosses a plane, or for the usual reasons."""
    before: list[Point] = []
    usual = end_reason(delta_limit)

    def stop(point: Point) -> object:
        crossed = crossed_plane(before[-1].state, point.state) if before else None
        before[:] = [point]
        return crossed or usual(point)

    return stop


def nearest_joint(
    paths: Iterable[Path], even: Mirror, state: HalfRod, limit: float = JOINT_DISTANCE
) -> tuple[Path, int, SpecialPoint] | None:
    """The pitchfork, among those of ``paths``, that lies at a planar state, if any.

    A plane turned by pi has the same numbers, so numbers are compared and not unknowns.
    """
    here = np.array([state.end_shortening, state.end_tension / state.scalars[5], state.sigma])
    best, nearest = None, limit
    for planar in paths:
        if planar.tracer.mirror is not even:
            continue
        for number, special in planar.pitchforks:
            there = special.point.state
            numbers = [there.end_shortening, there.end_tension / there.scalars[5], there.sigma]
            distance = float(np.abs(here - numbers).max())
            if distance < nearest:
                best, nearest = (planar, number, special), distance
    return best
