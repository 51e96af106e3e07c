"""Elimination of a chain of condensed elements: orthogonal, so stable for any growth along the rod.

The elements say  A_i Y_i + B_i p - Y_{i+1} = -r_i. Pairs of neighbouring relations are merged by
a QR factorisation (Wright's structured elimination) until one relation  E Y_0 + F Y_N + B p = r
is left. Plain transfer (Y_N as a function of Y_0) would lose exp(sqrt(t) l/2) digits in the outer
rod; over a few elements, as long as it grows by less than GROWTH, it is harmless and six times
cheaper, so that groups of elements are merged and not elements.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from derod.branches.half_rod import gauss as gauss  # first: it says where kernels are kept

GROUP = 6
"""Most elements written as one by plain transfer."""
GROWTH = 100.0
"""Largest entry of a group's transfer matrix, relative to the largest of its elements: about as
many digits are lost as this has."""


@njit(cache=True, error_model="numpy")
def _householder(T, rows, columns, width, share):  # type: ignore[no-untyped-def]
    """Triangularise the first ``columns`` columns of T (rows, width) in place; True if R has a
    negative determinant. ``share`` (width,) is room."""
    negative = False
    for c in range(columns):
        norm = 0.0
        for i in range(c, rows):
            norm += T[i, c] * T[i, c]
        norm = np.sqrt(norm)
        if T[c, c] > 0.0:
            norm = -norm
        pivot = T[c, c] - norm
        scale = 1.0 / (-pivot * norm)
        for k in range(c + 1, width):
            share[k] = pivot * T[c, k]
        for i in range(c + 1, rows):
            f = T[i, c]
            for k in range(c + 1, width):
                share[k] += f * T[i, k]
        for k in range(c + 1, width):
            share[k] *= scale
            T[c, k] -= share[k] * pivot
        for i in range(c + 1, rows):
            f = T[i, c]
            for k in range(c + 1, width):
                T[i, k] -= share[k] * f
        T[c, c] = norm
        # the reflection itself has determinant -1
        negative ^= norm > 0.0
    return negative


@njit(cache=True, error_model="numpy")
def _compose(A, r, first, last, rows, inputs, M, N):  # type: ignore[no-untyped-def]
    """Write elements first, first+1, ... as one, M (d, d + c + 1) = [A | B | -r]; returns its end.

    Stops before ``last``, at GROUP elements, or where M has grown by GROWTH. N is room.
    """
    d, c = rows.size, inputs.size
    width = d + c + 1
    for a in range(d):
        own, to = A[first, rows[a]], M[a]
        for b in range(d):
            to[b] = own[rows[b]]
        for b in range(c):
            to[d + b] = own[inputs[b]]
        to[width - 1] = -r[first, rows[a]]
    single = 1.0
    for a in range(d):
        for b in range(d):
            single = max(single, abs(M[a, b]))
    end = first + 1
    while end < min(last, first + GROUP):
        largest = 0.0
        for a in range(d):
            for b in range(d):
                single = max(single, abs(A[end, rows[a], rows[b]]))
        for a in range(d):
            own, to = A[end, rows[a]], N[a]
            for b in range(d):
                to[b] = 0.0
            for b in range(c):
                to[d + b] = own[inputs[b]]
            to[width - 1] = -r[end, rows[a]]
            for k in range(d):
                f, before = own[rows[k]], M[k]
                for b in range(width):
                    to[b] += f * before[b]
            for b in range(d):
                largest = max(largest, abs(to[b]))
        if not largest < GROWTH * single:
            break
        for a in range(d):
            to, before = M[a], N[a]
            for b in range(width):
                to[b] = before[b]
        end += 1
    return end


@njit(cache=True, error_model="numpy")
def reduce_chain(A, r, first, last, rows, inputs, out, kept, ends):  # type: ignore[no-untyped-def]
    """Merge elements first..last-1.

    A (E, 10, 14), r (E, 10) from ``condense``; rows (d,) the state components of this mirror
    class, inputs (c,) its parameter columns (10..13). kept (E, d, 3d + c + 1) and ends (E,): what
    back-substitution needs; ends[e] is where the group that starts with element e ends. Writes out
    (d, 2d + c + 1), the relation [E | F | B | r]; returns True where the eliminated triangles flip
    the determinant's sign.
    """
    d = rows.size
    c = inputs.size
    width = 3 * d + c + 1
    T = np.empty((2 * d, width))  # columns: Y_i | Y_0 | Y_{i+1} | p | r
    share = np.empty(width)
    M, N = np.empty((d, d + c + 1)), np.empty((d, d + c + 1))
    e = _compose(A, r, first, last, rows, inputs, M, N)
    ends[first] = e
    flip = (d * (e - first - 1)) % 2 == 1
    for a in range(d):
        after, own = out[a], M[a]
        for b in range(d):
            after[b] = own[b]
            after[d + b] = 0.0
        after[d + a] = -1.0
        for b in range(c + 1):
            after[2 * d + b] = own[d + b]
    while e < last:
        ends[e] = _compose(A, r, e, last, rows, inputs, M, N)
        for a in range(d):
            top, before = T[a], out[a]
            for b in range(d):
                top[b] = before[d + b]
                top[d + b] = before[b]
                top[2 * d + b] = 0.0
            for b in range(2 * d, 2 * d + c + 1):
                top[d + b] = before[b]
            below, own = T[d + a], M[a]
            for b in range(d):
                below[b] = own[b]
                below[d + b] = 0.0
                below[2 * d + b] = 0.0
            below[2 * d + a] = -1.0
            for b in range(d, d + c + 1):
                below[2 * d + b] = own[b]
        flip ^= _householder(T, 2 * d, d, width, share)
        flip ^= (d * (ends[e] - e - 1)) % 2 == 1
        for a in range(d):
            top, below, own, after = T[a], T[d + a], kept[e, a], out[a]
            for b in range(width):
                own[b] = top[b]
            for b in range(d, width):
                after[b - d] = below[b]
        e = ends[e]
    return flip


@njit(cache=True, error_model="numpy")
def expand_chain(kept, ends, A, r, first, last, node, rows, inputs, dp, own, dY):  # type: ignore[no-untyped-def]
    """Back-substitution: interior node increments from those of the chain's two ends.

    kept, ends from ``reduce_chain``, A and r what it was given. node: index in dY (nodes, 10) of
    the chain's first node, whose increment and that of its last node are already there; dp (4,)
    parameter increments; own = 1 for a Newton step, 0 for a derivative. Groups are gone through from the
    last to the first, elements inside a group from its start to its end.
    """
    d = rows.size
    c = inputs.size
    width = 3 * d + c + 1
    count = 0
    starts = np.empty(last - first, dtype=np.int64)
    e = first
    while e < last:
        starts[count] = e
        count += 1
        e = ends[e]
    for g in range(count - 1, -1, -1):
        e = starts[g]
        i, right = node + e - first, node + ends[e] - first
        if g > 0:
            for a in range(d - 1, -1, -1):
                total = own * kept[e, a, width - 1]
                for b in range(d):
                    total -= kept[e, a, d + b] * dY[node, rows[b]]
                    total -= kept[e, a, 2 * d + b] * dY[right, rows[b]]
                for b in range(c):
                    total -= kept[e, a, 3 * d + b] * dp[inputs[b] - 10]
                for b in range(a + 1, d):
                    total -= kept[e, a, b] * dY[i, rows[b]]
                dY[i, rows[a]] = total / kept[e, a, a]
        for k in range(e, ends[e] - 1):
            i = node + k - first
            for a in range(d):
                total = own * r[k, rows[a]]
                for b in range(d):
                    total += A[k, rows[a], rows[b]] * dY[i, rows[b]]
                for b in range(c):
                    total += A[k, rows[a], inputs[b]] * dp[inputs[b] - 10]
                dY[i + 1, rows[a]] = total


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
