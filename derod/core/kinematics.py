"""Rest lengths, edge lengths and tangents of a state."""

from __future__ import annotations

import math

from derod.core.grid import lay_grid
from derod.core.jit import kernel


@kernel
def measure(physics, mesh, q, b, kin):
    """Fill ``kin`` for the state (q, b); return False where an edge has no length or is not finite."""
    d = len(physics.axis)
    lay_grid(mesh, physics.length, b, kin)
    sound = True
    for j in range(kin.rest.size):
        square = 0.0
        for k in range(d):
            e = q[j + 1, k] - q[j, k]
            kin.tangent[j, k] = e
            square += e * e
        size = math.sqrt(square)
        kin.size[j] = size
        sound &= size > 0.0 and math.isfinite(size) and kin.rest[j] > 0.0
        inverse = 1.0 / size
        for k in range(d):
            kin.tangent[j, k] *= inverse
    return sound
