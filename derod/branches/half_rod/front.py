"""Elimination of unknowns from the front of a symmetric indefinite matrix, signs of pivots counted.

Bunch and Parlett's pivots (1971) among the unknowns that leave: the largest diagonal entry, or,
where an entry beside the diagonal is much larger, the 2 x 2 block of that one, which has one
negative eigenvalue by its choice. What is left is the Schur complement, so that by Sylvester's law
the negative pivots and the negative eigenvalues of what is left add up to those of the whole.
"""

from __future__ import annotations

import numpy as np
from numba import njit

PREFER_DIAGONAL = 0.6404
"""(1 + sqrt(17))/8: the least growth of entries."""


@njit(cache=True, error_model="numpy")
def eliminate(F, first, last, gone):  # type: ignore[no-untyped-def]
    """Eliminate the unknowns first..last-1 of the symmetric F (n, n) in place.

    Their rows and columns are zero afterwards. ``gone`` (n,) is room. Returns the number of
    negative pivots, or -1 where only zero or non-finite pivots are left.
    """
    n = F.shape[0]
    gone[:] = 0.0
    negative = 0
    left = last - first
    while left > 0:
        diagonal, beside = -1.0, -1.0
        at, row, column = first, first, first
        for i in range(first, last):
            if gone[i] != 0.0:
                continue
            if abs(F[i, i]) > diagonal:
                diagonal, at = abs(F[i, i]), i
            for j in range(first, i):
                if gone[j] == 0.0 and abs(F[i, j]) > beside:
                    beside, row, column = abs(F[i, j]), i, j
        if not (0.0 < max(diagonal, beside) < 1e300):
            return -1
        if diagonal >= PREFER_DIAGONAL * beside:
            pivot = F[at, at]
            negative += pivot < 0.0
            gone[at] = 1.0
            left -= 1
            for i in range(n):
                f = F[i, at] / pivot
                if f == 0.0 or gone[i] != 0.0:
                    continue
                for j in range(n):
                    F[i, j] -= f * F[at, j]
            F[at, :] = 0.0
            F[:, at] = 0.0
        else:
            a, b, c = F[row, row], F[row, column], F[column, column]
            scale = 1.0 / (a / b * c - b)  # b over the determinant
            negative += 1
            gone[row], gone[column] = 1.0, 1.0
            left -= 2
            for i in range(n):
                if gone[i] != 0.0:
                    continue
                u, v = F[i, row], F[i, column]
                if u == 0.0 and v == 0.0:
                    continue
                f = scale * (c / b * u - v)
                g = scale * (a / b * v - u)
                for j in range(n):
                    F[i, j] -= f * F[row, j] + g * F[column, j]
            for k in (row, column):
                F[k, :] = 0.0
                F[:, k] = 0.0
    return negative


def negative_eigenvalues(matrix: np.ndarray) -> int:
    """Number of negative eigenvalues of a small symmetric matrix, its rows made comparable first.

    Raises ValueError where the matrix is not finite.
    """
    if not np.isfinite(matrix).all():
        raise ValueError("the matrix whose negative eigenvalues are counted is not finite")
    scale = np.abs(matrix).max(axis=1)
    scale = 1.0 / np.sqrt(np.where(scale > 0.0, scale, 1.0))
    return int((np.linalg.eigvalsh(matrix * np.outer(scale, scale)) < 0.0).sum())
