"""Rest lengths, edge lengths, tangents of a state, and how tangents change along it."""

from __future__ import annotations

import math

from derod.algebra.jit import inlined
from derod.rod.frames import measure_frames
from derod.rod.grid import lay_grid


@inlined
def measure(physics, mesh, q, b, kin):
    """Fill ``kin`` for the state (q, b); return False where an edge has no length or is not finite."""
    lay_grid(mesh, physics.length, b, kin)
    sound = fill_tangents(physics.axis, q, kin)
    fill_changes(physics.axis, kin)
    fill_differences(physics.axis, kin)
    measure_frames(q, kin, kin.frames)
    return sound


@inlined
def fill_tangents(axis, q, kin):
    """Fill the edges' lengths and tangents."""
    n = kin.rest.size - 2
    for k in range(len(axis)):
        for e in range(1, n + 1):
            kin.tangent[k, e] = q[e, k] - q[e - 1, k]
    for e in range(1, n + 1):
        square = 0.0
        for k in range(len(axis)):
            square += kin.tangent[k, e] ** 2
        kin.size[e] = math.sqrt(square)
    for e in range(1, n + 1):
        kin.inverse[e] = 1.0 / kin.size[e]
    for k in range(len(axis)):
        for e in range(1, n + 1):
            kin.tangent[k, e] *= kin.inverse[e]
    unsound = 0
    for e in range(1, n + 1):
        unsound += not (kin.size[e] > 0.0 and kin.rest[e] > 0.0)  # NaN where anything is
    return unsound == 0


@inlined
def fill_changes(axis, kin):
    """Fill the tangents' changes at the vertices, and 1 - cos(phi) = |change|^2 / 2 of them."""
    vertices = kin.fall.size
    for k in range(len(axis)):
        for i in range(vertices):
            kin.change[k, i] = kin.tangent[k, i + 1] - kin.tangent[k, i]
    for i in range(vertices):
        square = 0.0
        for k in range(len(axis)):
            square += kin.change[k, i] ** 2
        kin.fall[i] = 0.5 * square
    for i in range(vertices):
        kin.weight[i] = 1.0 / (kin.rest[i] + kin.rest[i + 1])


@inlined
def fill_differences(axis, kin):
    """Fill d = (1 - t t^T) s, the difference of the curvatures at an edge's two ends, and t.s.

    s = alpha t_+ + beta t_-, taken from the changes of t, so that no digits are lost on short edges.
    """
    n = kin.rest.size - 2
    d, w = kin.difference, kin.weight
    for k in range(len(axis)):
        for e in range(1, n + 1):
            d[k, e] = 2 * (w[e] * kin.change[k, e] - w[e - 1] * kin.change[k, e - 1])
    for e in range(1, n + 1):
        dot = 0.0
        for k in range(len(axis)):
            dot += kin.tangent[k, e] * d[k, e]
        kin.along[e] = dot
    for k in range(len(axis)):
        for e in range(1, n + 1):
            d[k, e] -= kin.along[e] * kin.tangent[k, e]
    for e in range(1, n + 1):
        kin.along[e] += 2 * (w[e] + w[e - 1])
