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
    least = 1.0  # NaN where anything is
    for e in range(1, kin.rest.size - 1):
        square = 0.0
        for k in range(d):
            x = q[e, k] - q[e - 1, k]
            kin.tangent[e, k] = x
            square += x * x
        size = math.sqrt(square)
        inverse = 1.0 / size
        kin.size[e] = size
        kin.inverse[e] = inverse
        for k in range(d):
            kin.tangent[e, k] *= inverse
        if not (size > 0.0 and kin.rest[e] > 0.0):
            least = 0.0
    for i in range(kin.rest.size - 1):
        kin.weight[i] = 1.0 / (kin.rest[i] + kin.rest[i + 1])
    return least > 0.0
