"""Gauss collocation: the tableau of STAGES points and its dense output."""

from __future__ import annotations

import numpy as np

from derod.algebra import cache as _cache

_cache.point_numba_at_own_cache()  # all kernels of the branches are imported after this

STAGES = 5
"""Collocation points an element; nodal values converge with order 2 * STAGES."""


def lagrange_integrals(points: np.ndarray, upper: np.ndarray) -> np.ndarray:
    """Integrals from 0 to upper[j] of the Lagrange basis through ``points``: (len(upper),
    len(points))."""
    count = len(points)
    out = np.empty((len(upper), count))
    for k in range(count):
        others = np.delete(points, k)
        basis = np.poly1d(others, r=True) / np.prod(points[k] - others)
        primitive = basis.integ()
        out[:, k] = primitive(upper) - primitive(0.0)
    return out


def gauss_tableau(stages: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Nodes (m,), weights (m,) and matrix (m, m) of the Gauss method of order 2 m on [0, 1]."""
    x, w = np.polynomial.legendre.leggauss(stages)
    nodes = 0.5 * (x + 1.0)
    return nodes, 0.5 * w, lagrange_integrals(nodes, nodes)


NODES, WEIGHTS, MATRIX = gauss_tableau(STAGES)
