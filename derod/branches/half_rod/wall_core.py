"""The wall's potential with its cone at r = 0 rounded off, for second variations.

v(r) = v0/(1 + rho - 2 r) has a cone at the drop's centre. A rod that runs through it feels the
second derivative across, 2 v0/((1 + rho)^2 r), whose integral along the rod is logarithmic: without a
core the centre of such a rod could not move sideways at all to second order, and a mesh would decide
how little. Where r is below a core radius c the distance is therefore replaced by the even polynomial
that meets it with two derivatives,

    r = c (3 + 6 y - y^2)/8,    y = |w|^2/c^2.
"""

from __future__ import annotations

from numba import njit

from derod.branches.half_rod.element import wall_gradient

CORE = 0.01
"""D. The results for states through the centre depend on it, like its logarithm."""


@njit(cache=True, error_model="numpy")
def cored_wall(w, strength, softness, core, grad, hess):  # type: ignore[no-untyped-def]
    """``wall_gradient`` with a core of radius ``core`` (0: none); returns the gap."""
    square = w[0] * w[0] + w[1] * w[1] + w[2] * w[2]
    if square >= core * core:
        return wall_gradient(w, strength, softness, grad, hess)
    y = square / (core * core)
    gap = 1.0 + softness - 0.25 * core * (3.0 + 6.0 * y - y * y)
    slope = 2.0 * strength / (gap * gap)
    first = (0.75 - 0.25 * y) / core  # dr/d|w|^2, and its derivative
    second = -0.25 / (core * core * core)
    along = 4.0 * slope * (second + 4.0 / gap * first * first)
    for i in range(3):
        grad[i] = 2.0 * slope * first * w[i]
        for j in range(3):
            hess[i, j] = along * w[i] * w[j]
        hess[i, i] += 2.0 * slope * first
    return gap
