"""Whether a mesh is fine enough for the coil on it.

Turning angles above COARSE at a node cost 1e-3 in E_hat.
"""

from __future__ import annotations

import math

COARSE = 0.5  # rad of turning at a node, above which a mesh is too coarse
FINE = 0.4  # rad, at which it would do


def edges_enough(edges: int, turning: float) -> int:
    """Return how many edges would do, where a node of a mesh of ``edges`` turns by ``turning`` (rad)."""
    return math.ceil(edges * turning / FINE / 10) * 10
