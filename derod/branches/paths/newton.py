"""Newton's method for the half rod, kept inside the wall."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from derod.branches.half_rod.linear import Reduced, linearise
from derod.branches.half_rod.mirror import Mirror
from derod.branches.half_rod.outcome import NotConverged
from derod.branches.half_rod.state import HalfRod

TOLERANCE = 1e-10
MAX_ITERATIONS = 8
WALL_SHARE = 0.2
"""No step may shrink the least gap to the wall below this share of it."""


@dataclass(frozen=True)
class Settled:
    """A converged state with its eliminated linearisation."""

    state: HalfRod
    reduced: Reduced
    iterations: int


def settle(
    state: HalfRod,
    mirror: Mirror,
    closing: np.ndarray,
    values: np.ndarray,
    tolerance: float = TOLERANCE,
    max_iterations: int = MAX_ITERATIONS,
) -> Settled:
    """Solve the half-rod equations closed by ``closing`` (c, 37) . kept unknowns = ``values`` (c,).

    c = 2, or 3 where the weight is an unknown (``Reduced.solve``).

    Ends when no equation's residual exceeds ``tolerance``; the linearisation returned is that of
    the final state. Raises NotConverged after ``max_iterations``, at the wall, or on a singular
    matrix.
    """
    elements = linearise(state)
    for iteration in range(max_iterations + 1):
        missing = values - closing @ state.kept
        residual = max(elements.residual, float(np.abs(missing).max()))
        if not math.isfinite(residual) or elements.gap <= 0.0:
            raise NotConverged(f"the state left the wall's inside (residual {residual:.1e})")
        reduced = Reduced(elements, mirror)
        if residual <= tolerance:
            return Settled(state, reduced, iteration)
        if iteration == max_iterations:
            break
        try:
            kept = reduced.solve(closing, np.array([[*missing, 1.0]]))[0]
        except np.linalg.LinAlgError as error:
            raise NotConverged("singular Jacobian") from error
        step = reduced.expand(kept, 1.0)
        factor = 1.0
        least = WALL_SHARE * elements.gap
        elements = linearise(state.moved(step))
        while not elements.gap > least:
            factor *= 0.5
            if factor < 1e-3:
                raise NotConverged("the wall stops the step")
            elements = linearise(state.moved(step, factor))
        state = elements.state
    raise NotConverged(f"residual {residual:.1e} after {max_iterations} iterations")
