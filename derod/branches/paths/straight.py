"""The straight rod in the drop, where it buckles, and the first buckled state."""

from __future__ import annotations

import numpy as np
from scipy.optimize import brentq

from derod.branches.half_rod import closure as col
from derod.branches.half_rod.gauss import NODES
from derod.branches.half_rod.linear import Reduced, linearise
from derod.branches.half_rod.mesh import RESOLUTION, adapted
from derod.branches.half_rod.mirror import Mirror
from derod.branches.half_rod.parameters import Parameters
from derod.branches.half_rod.state import HalfRod, Increment
from derod.branches.paths.newton import Settled, settle

SCAN = 120
"""Tensions looked at between f_gamma and the clamped rod's own Euler load."""


class NoBuckling(ArithmeticError):  # noqa: N818 - an outcome, not a fault
    """The straight rod does not buckle in this mirror class."""


def straight_state(
    parameters: Parameters, tension: float, inner: int = 16, outer: int = 16
) -> HalfRod:
    """The straight rod under an end tension (K0/D^2), twisted by R/l, a weightless drop at its middle.

    With a weight the straight rod is no equilibrium: heavy paths start from the weightless ones
    (``weight``), and the state says W = 0 whatever the parameters' own.
    """
    prm = parameters
    half = 0.5 * prm.length
    # graded toward the middle (the wall's cone) and toward the meniscus
    inside = np.linspace(0.0, 1.0, inner + 1) ** 1.5
    outside = np.linspace(0.0, 1.0, outer + 1) ** 2.0
    eta = np.concatenate([np.diff(inside), np.diff(outside)])
    sigma = 0.5
    twist = prm.end_rotation / prm.length
    scalars = np.array(
        [0.0, prm.twisting * twist, twist, sigma, 0.0, prm.capillary_force, 0.0], dtype=float
    )

    def places(eta_part: np.ndarray, ends: np.ndarray, start: float, length: float) -> np.ndarray:
        gauss = start + length * (ends[:-1, None] + eta_part[:, None] * NODES)
        return np.asarray(gauss)

    def state(s: np.ndarray, wet: bool) -> np.ndarray:
        out = np.zeros((s.size, 10))
        out[:, 2] = s
        out[:, 3], out[:, 6] = np.cos(0.5 * twist * s), np.sin(0.5 * twist * s)
        out[:, 9] = tension
        if wet:
            wall = prm.wall_strength / (1.0 + prm.wall_softness - 2.0 * s)
            out[:, 9] += wall - prm.capillary_force
        return out

    nodes = np.concatenate(
        [state(sigma * inside, True), state(sigma + (half - sigma) * outside, False)]
    )
    gauss = np.concatenate(
        [
            places(eta[:inner], inside, 0.0, sigma),
            places(eta[inner:], outside, sigma, half - sigma),
        ]
    )
    stages = state(gauss.ravel(), False)[:, 3:7].reshape(*gauss.shape, 4)
    return HalfRod(prm, eta, inner, nodes, stages, scalars)


def buckling_tensions(parameters: Parameters, mirror: Mirror, count: int = 1) -> list[float]:
    """The largest ``count`` end tensions at which the straight rod buckles in a mirror class.

    Zeros of the class's determinant, looked for from f_gamma down to the Euler load -4 pi^2/l^2.
    Raises NoBuckling when there is none.
    """

    def determinant(tension: float) -> float:
        return Reduced(linearise(straight_state(parameters, tension)), mirror).determinant()

    tensions = np.linspace(
        parameters.capillary_force, -((2.0 * np.pi / parameters.length) ** 2), SCAN
    )
    values = [determinant(t) for t in tensions]
    out = []
    for a, b, fa, fb in zip(tensions[:-1], tensions[1:], values[:-1], values[1:], strict=True):
        if fa * fb < 0.0:
            out.append(float(brentq(determinant, b, a, xtol=1e-12)))
            if len(out) == count:
                return out
    if not out:
        raise NoBuckling(
            f"the straight rod does not buckle: no zero of the determinant ({mirror.name}) for "
            f"tensions from {tensions[0]:g} to {tensions[-1]:g}"
        )
    return out


def null_increment(reduced: Reduced) -> Increment:
    """The null vector of a (nearly) singular square block, largest kept component 1."""
    _, _, right = np.linalg.svd(reduced.square())
    kept = np.zeros(col.KEPT)
    kept[reduced.columns] = right[-1]
    kept /= kept[np.abs(kept).argmax()]
    return reduced.expand(kept, 0.0)


def first_buckled(
    parameters: Parameters,
    tension: float,
    perturbation: Mirror,
    branch: Mirror,
    held: int,
    amplitude: float,
    tolerance: float,
    resolution: float = RESOLUTION,
) -> Settled:
    """A slightly buckled state: kept unknown number ``held`` fixed at ``amplitude``."""
    state = straight_state(parameters, tension)
    mode = null_increment(Reduced(linearise(state), perturbation))
    kept = np.concatenate([mode.nodes[[0, state.inner, -1]].ravel(), mode.scalars])
    state = adapted(state.moved(mode, amplitude / kept[held]), resolution)
    closing = np.zeros((2, col.KEPT))
    closing[0, col.FGAMMA] = 1.0
    closing[1, held] = 1.0
    values = np.array([parameters.capillary_force, amplitude])
    return settle(state, branch, closing, values, tolerance, max_iterations=20)
