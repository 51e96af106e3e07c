r"""The inverse and the inertia of a small symmetric indefinite matrix, in place.

Symmetric sweeps (Gauss and Jordan's elimination, which keeps symmetry) with the complete pivoting of
Bunch and Parlett (1971): the largest diagonal entry of what is left, or, where an entry beside the
diagonal is much larger, the 2 x 2 block of that one. What is left after each sweep is the Schur
complement, so that the pivots tell the inertia: a 2 x 2 pivot has one negative eigenvalue, by its choice.

numpy's routines would do, but they allocate inside the hot loop and take seconds to compile.
"""

from __future__ import annotations

from derod.algebra.jit import inlined, kernel

PREFER_DIAGONAL = 0.6404  # (1 + sqrt(17))/8: the least growth of entries


@kernel
def invert(a, swept):
    """Replace ``a``, (m, m), by its inverse; return its number of negative eigenvalues.

    Returns -1, with ``a`` spoiled, where it is singular or not finite. ``swept``, (m,), is room.
    """
    m = swept.size
    swept[:] = 0.0
    negative, done = 0, 0
    while done < m:
        diagonal, beside = 0.0, 0.0
        at, row, column = 0, 0, 0
        for i in range(m):
            if swept[i] != 0.0:
                continue
            for j in range(i + 1):
                if swept[j] != 0.0:
                    continue
                size = abs(a[i, j])
                if not size <= 1e300:
                    return -1
                if i == j and size > diagonal:
                    diagonal, at = size, i
                elif i != j and size > beside:
                    beside, row, column = size, i, j
        if diagonal == 0.0 and beside == 0.0:
            return -1
        if diagonal >= PREFER_DIAGONAL * beside:
            negative += a[at, at] < 0
            sweep(a, at)
            swept[at] = 1.0
            done += 1
        else:
            negative += 1
            sweep_pair(a, row, column)
            swept[row] = swept[column] = 1.0
            done += 2
    for i in range(m):
        for j in range(m):
            a[i, j] = -a[i, j]
    return negative


@inlined
def sweep(a, k):
    """Sweep the symmetric ``a`` on k: [[p, r^T], [r, A]] becomes [[-1/p, r^T/p], [r/p, A - r r^T/p]]."""
    m = a.shape[0]
    inverse = 1.0 / a[k, k]
    for i in range(m):
        if i == k:
            continue
        f = a[i, k] * inverse
        for j in range(m):
            if j != k:
                a[i, j] -= f * a[k, j]
    for i in range(m):
        a[i, k] *= inverse
        a[k, i] = a[i, k]
    a[k, k] = -inverse


@inlined
def sweep_pair(a, k, o):
    """Sweep the symmetric ``a`` on the block of k and o, as ``sweep`` does on one row."""
    m = a.shape[0]
    kk, ko, oo = a[k, k], a[k, o], a[o, o]
    scale = 1.0 / (kk / ko * oo - ko)  # ko over the determinant
    by_kk, by_oo, by_ko = oo / ko * scale, kk / ko * scale, -scale
    for i in range(m):
        if i in (k, o):
            continue
        f = a[i, k] * by_kk + a[i, o] * by_ko
        g = a[i, k] * by_ko + a[i, o] * by_oo
        for j in range(m):
            if j not in (k, o):
                a[i, j] -= f * a[k, j] + g * a[o, j]
    for i in range(m):
        f = a[i, k] * by_kk + a[i, o] * by_ko
        g = a[i, k] * by_ko + a[i, o] * by_oo
        a[i, k] = a[k, i] = f
        a[i, o] = a[o, i] = g
    a[k, k], a[k, o], a[o, k], a[o, o] = -by_kk, -by_ko, -by_ko, -by_oo
