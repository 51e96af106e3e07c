"""Choose the arc-length grid: how many edges inside the drop, and how they are graded."""

from __future__ import annotations

import numpy as np

from derod.core.layout import Mesh

WETTED_SHARE = 0.65  # of the edges
LAYER = 0.12  # D; the boundary layers beside the menisci are 1/sqrt(t) = 0.2 to 0.5 wide
INNER_GRADING = 0.9  # logarithm of the longest inner edge over the shortest


def wetted_mesh(
    edges: int, *, share: float = WETTED_SHARE, layer: float = LAYER, grading: float = INNER_GRADING
) -> Mesh:
    """Return a grid of ``edges`` edges: a share of them wetted, the rest halved between the ends."""
    inside = round(share * edges)
    inside += (edges - inside) % 2
    place = (np.arange(inside) + 0.5) / inside
    weights = np.exp(grading * np.sin(np.pi * place) ** 2)
    return Mesh((edges - inside) // 2, weights / weights.sum(), layer)


def dry_mesh(edges: int) -> Mesh:
    """Return a uniform grid for a rod without a drop."""
    return Mesh(0, np.full(edges, 1 / edges), LAYER)
