"""Unstable modes of planar states, in their plane and out of it, and the section that takes the latter away.

Of a planar state whose plane is a principal one of the section the second variation is the sum of a form in
the plane and one out of it. The first does not know of K3 nor of the other bending stiffness K2; the second
is affine in both and grows with them, as phi'.K phi' does: there is one K3/K1, and one aspect ratio of
rectangles, from which the state is stable out of its plane.

Each part is counted by raising the other's rotations (``second_variation``). A rod through the drop's
centre has the wall's cone rounded off within ``wall_core.CORE`` = 0.01 D.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import brentq

from derod.branches.half_rod.mirror import S_EVEN
from derod.branches.half_rod.state import HalfRod
from derod.branches.half_rod.symmetry import plane
from derod.branches.paths.stability import counts

RAISED = 1e6
"""K1/D^2, on rotations that shall not take part: more than any load."""
SOFTEST, STIFFEST = 1e-3, 1e6
"""K3/K1 looked at."""
WIDEST = 100.0
"""w/h looked at: K2/K1 = 1e4. Beyond, rounding of K2/h^3 would count."""


@dataclass(frozen=True, slots=True)
class PlanarModes:
    """Numbers of unstable modes, the drop held in its place along the rod."""

    in_even: int  # in the plane, flip-even
    in_odd: int
    out_even: int  # out of it
    out_odd: int

    @property
    def inside(self) -> int:
        """Those in the plane."""
        return self.in_even + self.in_odd

    @property
    def outside(self) -> int:
        """Those out of it."""
        return self.out_even + self.out_odd


def planar_modes(state: HalfRod, core: float | None = None) -> PlanarModes:
    """Count the modes of a planar state; ``core``: of the wall, D. Raises ValueError for a space curve."""
    found = plane(state)
    if found is None:
        raise ValueError("the state is not planar")
    # rotations in the plane are about its normal: e_y of point-symmetric curves, e_x of loops
    normal = np.array([0.0, 1.0, 0.0] if found[0] is S_EVEN else [1.0, 0.0, 0.0])
    inside = counts(state, RAISED * (1.0 - normal), core)
    outside = counts(state, RAISED * normal, core)
    return PlanarModes(*inside, *outside)


def critical_twisting(state: HalfRod, bending_2: float, core: float | None = None) -> float | None:
    """The K3/K1 from which a planar state is stable out of its plane with this K2/K1.

    None where no K3/K1 up to STIFFEST is enough; SOFTEST where the least looked at is.
    """

    def unstable(twisting: float) -> bool:
        return _unstable(state, twisting, bending_2, core)

    return _threshold(unstable, SOFTEST, STIFFEST)


def critical_aspect(
    state: HalfRod,
    twisting: Callable[[float], float],
    widest: float = WIDEST,
    core: float | None = None,
) -> float | None:
    """The aspect ratio w/h from which a rectangle is stable out of its plane: K2/K1 = (w/h)^2.

    ``twisting``: K3/K1 as a function of w/h that grows with it. None where ``widest`` is not enough.
    """

    def unstable(aspect: float) -> bool:
        return _unstable(state, twisting(aspect), aspect * aspect, core)

    return _threshold(unstable, 1.0, widest)


def _unstable(state: HalfRod, twisting: float, bending_2: float, core: float | None) -> bool:
    parameters = replace(state.parameters, twisting=twisting, bending_2=bending_2)
    return planar_modes(state.with_parameters(parameters), core).outside > 0


def _threshold(unstable: Callable[[float], bool], low: float, high: float) -> float | None:
    """Where ``unstable`` ends, by bisection in the logarithm; it ends once, if at all."""
    if not unstable(low):
        return low
    if unstable(high):
        return None

    def side(x: float) -> float:
        return 1.0 if unstable(float(np.exp(x))) else -1.0

    return float(np.exp(brentq(side, np.log(low), np.log(high), xtol=1e-10)))
