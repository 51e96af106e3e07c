"""Elimination of a chain of condensed elements: orthogonal, so stable for any growth along the rod.

The elements say  A_i Y_i + B_i p - Y_{i+1} = -r_i. Pairs of neighbouring relations are merged by
a QR factorisation (Wright's structured elimination) until one relation  E Y_0 + F Y_N + B p = r
is left. Plain transfer (Y_N as a function of Y_0) would lose exp(sqrt(t) l/2) digits in the outer
rod.
"""

from __future__ import annotations

import numpy as np
from numba import njit


@njit(cache=True, error_model="numpy")
def _householder(T, rows, columns, width):  # type: ignore[no-untyped-def]
    """Triangularise the first ``columns`` columns of T (rows, width) in place; True if R has a
    negative determinant."""
    negative = False
    for c in range(columns):
        norm = 0.0
        for i in range(c, rows):
            norm += T[i, c] * T[i, c]
        norm = np.sqrt(norm)
        if T[c, c] > 0.0:
            norm = -norm
        pivot = T[c, c] - norm
        scale = -pivot * norm
        for k in range(c + 1, width):
            total = pivot * T[c, k]
            for i in range(c + 1, rows):
                total += T[i, c] * T[i, k]
            total /= scale
            T[c, k] -= total * pivot
            for i in range(c + 1, rows):
                T[i, k] -= total * T[i, c]
        T[c, c] = norm
        # the reflection itself has determinant -1
        negative ^= norm > 0.0
    return negative


@njit(cache=True, error_model="numpy")
def reduce_chain(A, r, first, last, rows, inputs, out, kept):  # type: ignore[no-untyped-def]
    """Merge elements first..last-1.

    A (E, 10, 14), r (E, 10) from ``condense``; rows (d,) the state components of this mirror
    class, inputs (c,) its parameter columns (10..13). kept (E, d, 3d + c + 1): what
    back-substitution needs. Writes out (d, 2d + c + 1), the relation [E | F | B | r]; returns
    True where the eliminated triangles flip the determinant's sign.
    """
    d = rows.size
    c = inputs.size
    width = 3 * d + c + 1
    T = np.empty((2 * d, width))  # columns: Y_i | Y_0 | Y_{i+1} | p | r
    for a in range(d):
        for b in range(d):
            out[a, b] = A[first, rows[a], rows[b]]
            out[a, d + b] = -1.0 if a == b else 0.0
        for b in range(c):
            out[a, 2 * d + b] = A[first, rows[a], inputs[b]]
        out[a, 2 * d + c] = -r[first, rows[a]]
    flip = False
    for e in range(first + 1, last):
        for a in range(d):
            for b in range(d):
                T[a, b] = out[a, d + b]
                T[a, d + b] = out[a, b]
                T[a, 2 * d + b] = 0.0
                T[d + a, b] = A[e, rows[a], rows[b]]
                T[d + a, d + b] = 0.0
                T[d + a, 2 * d + b] = -1.0 if a == b else 0.0
            for b in range(c):
                T[a, 3 * d + b] = out[a, 2 * d + b]
                T[d + a, 3 * d + b] = A[e, rows[a], inputs[b]]
            T[a, width - 1] = out[a, 2 * d + c]
            T[d + a, width - 1] = -r[e, rows[a]]
        flip ^= _householder(T, 2 * d, d, width)
        kept[e] = T[:d]
        for a in range(d):
            for b in range(d):
                out[a, b] = T[d + a, d + b]
                out[a, d + b] = T[d + a, 2 * d + b]
            for b in range(c + 1):
                out[a, 2 * d + b] = T[d + a, 3 * d + b]
    return flip


@njit(cache=True, error_model="numpy")
def expand_chain(kept, first, last, node, rows, inputs, dp, own, dY):  # type: ignore[no-untyped-def]
    """Back-substitution: interior node increments from those of the chain's two ends.

    node: index in dY (nodes, 10) of the chain's first node, whose increment and that of its last
    node are already there; dp (4,) parameter increments; own = 1 for a Newton step, 0 for a
    derivative.
    """
    d = rows.size
    c = inputs.size
    width = 3 * d + c + 1
    for e in range(last - 1, first, -1):
        i = node + e - first
        for a in range(d - 1, -1, -1):
            total = own * kept[e, a, width - 1]
            for b in range(d):
                total -= kept[e, a, d + b] * dY[node, rows[b]]
                total -= kept[e, a, 2 * d + b] * dY[i + 1, rows[b]]
            for b in range(c):
                total -= kept[e, a, 3 * d + b] * dp[inputs[b] - 10]
            for b in range(a + 1, d):
                total -= kept[e, a, b] * dY[i, rows[b]]
            dY[i, rows[a]] = total / kept[e, a, a]


@njit(cache=True, error_model="numpy")
def expand_stages(X, inner, dY, dp, own, dQ):  # type: ignore[no-untyped-def]
    """Stage increments dQ (E, m, 4) from node and parameter increments, with ``condense``'s X."""
    E, size, width = X.shape
    for e in range(E):
        left = e if e < inner else e + 1
        for row in range(size):
            total = own * X[e, row, width - 1]
            for b in range(10):
                total += X[e, row, b] * dY[left, b]
            for b in range(4):
                total += X[e, row, 10 + b] * dp[b]
            dQ[e, row // 4, row % 4] = total
