"""The arc-length grid: three regions tied to the menisci, graded toward them.

Rest lengths are linear in s_A and s_B, l_j = base + by_a s_A + by_b s_B, so that the energy is smooth
in the menisci's places. Outside, edges shrink exponentially toward the meniscus, where the boundary
layers of width 1/sqrt(t) lie.
"""

from __future__ import annotations

import numpy as np

from derod.core.layout import Mesh

WETTED_SHARE = 0.5  # of the edges
OUTER_GRADING = 3.5  # logarithm of the longest outer edge over the shortest
INNER_GRADING = 0.0


def exponential_fractions(count: int, grading: float) -> np.ndarray:
    """Return ``count`` fractions of a length, falling from first to last by exp(grading)."""
    weights = np.exp(-grading * np.arange(count) / max(count - 1, 1))
    return weights / weights.sum()


def inner_fractions(count: int, grading: float) -> np.ndarray:
    """Return ``count`` mirror-symmetric fractions, longest in the middle by exp(grading)."""
    place = (np.arange(count) + 0.5) / count
    weights = np.exp(grading * np.sin(np.pi * place) ** 2)
    return weights / weights.sum()


def make_mesh(
    length: float,
    edges: int,
    share: float = WETTED_SHARE,
    outer: float = OUTER_GRADING,
    inner: float = INNER_GRADING,
) -> Mesh:
    """Lay ``edges`` edges along a rod of ``length`` (D), the menisci between regions.

    Returns the ``Mesh`` whose rest lengths follow s_A and s_B.
    """
    inside = round(share * edges)
    inside += (edges - inside) % 2
    outside = (edges - inside) // 2
    base, by_a, by_b = np.zeros((3, edges))
    fractions = exponential_fractions(outside, outer)
    by_a[:outside] = fractions
    wetted = inner_fractions(inside, inner)
    by_a[outside : outside + inside] = -wetted
    by_b[outside : outside + inside] = wetted
    base[outside + inside :] = length * fractions[::-1]
    by_b[outside + inside :] = -fractions[::-1]
    return Mesh(base, by_a, by_b, outside, outside + inside)
