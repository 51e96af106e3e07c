"""LDL^T of a symmetric indefinite band with a border, and its inertia, in O(n).

    [[K, B], [B^T, C]],   K = L D L^T,   S = C - B^T K^{-1} B

K is factored without pivoting: each multiplier comes after its edge's nodes, so that a pivot only
vanishes by accident; the factor is then not finite, and says so. By Sylvester's law the whole matrix
has as many negative eigenvalues as D and S together. Zero blocks stay exactly zero: a planar state gets
no force out of its plane.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from derod.core.jit import kernel


class Factor(NamedTuple):
    """A factored bordered band matrix."""

    lower: np.ndarray  # (n + w, w + 1): D on lower[:, 0], L's columns beside it
    half: np.ndarray  # (n + w, m): L^{-1} B
    scale: np.ndarray  # (m,) that makes S's rows comparable
    schur: np.ndarray  # (m, m) S, scaled
    right: np.ndarray  # (n + w,) room for a right side that is kept
    right_border: np.ndarray  # (m,)
    rhs: np.ndarray  # (n + w,) room for a right side, then its solution
    rhs_border: np.ndarray  # (m,)


def new_factor(rows: int, stride: int, borders: int) -> Factor:
    """Return room for the factor of a band of shape (rows, stride), padding included."""
    return Factor(
        np.zeros((rows, stride)),
        np.zeros((rows, borders)),
        np.zeros(borders),
        np.zeros((borders, borders)),
        np.zeros(rows),
        np.zeros(borders),
        np.zeros(rows),
        np.zeros(borders),
    )


@kernel
def factorize(linear, factor):
    """Factor the matrix; return its number of negative eigenvalues, or -1 if it is not finite."""
    lower, half, schur = factor.lower, factor.half, factor.schur
    rows, stride = lower.shape
    n = rows - stride + 1
    m = half.shape[1]
    lower[:] = linear.band
    half[:] = linear.border
    schur[:] = linear.corner
    negative = 0
    for j in range(n):
        pivot = lower[j, 0]
        negative += pivot < 0
        inverse = 1.0 / pivot
        for k in range(1, stride):
            f = lower[j, k] * inverse
            if f == 0.0:
                continue
            for i in range(k, stride):
                lower[j + k, i - k] -= f * lower[j, i]
            for i in range(m):
                half[j + k, i] -= f * half[j, i]
        for k in range(1, stride):
            lower[j, k] *= inverse
        for k in range(m):
            f = half[j, k] * inverse
            for i in range(m):
                schur[k, i] -= f * half[j, i]
    if not np.isfinite(np.sum(schur)):
        return -1
    for k in range(m):
        factor.scale[k] = 1.0 / np.sqrt(np.max(np.abs(schur[k])) + 1e-300)
    for k in range(m):
        for i in range(m):
            schur[k, i] *= factor.scale[k] * factor.scale[i]
    return negative + np.sum(np.linalg.eigvalsh(schur) < 0)


@kernel
def solve(factor, x, y):
    """Solve in place: ``x`` ((n + w,), padding zero) and ``y`` ((m,)) are right side, then solution."""
    lower, half = factor.lower, factor.half
    rows, stride = lower.shape
    n = rows - stride + 1
    m = half.shape[1]
    for j in range(n):
        f = x[j]
        for k in range(1, stride):
            x[j + k] -= lower[j, k] * f
        f /= lower[j, 0]
        for k in range(m):
            y[k] -= half[j, k] * f
    y[:] = factor.scale * np.linalg.solve(factor.schur, factor.scale * y)
    x[n:] = 0.0
    for j in range(n - 1, -1, -1):
        f = x[j]
        for k in range(m):
            f -= half[j, k] * y[k]
        f /= lower[j, 0]
        for k in range(1, stride):
            f -= lower[j, k] * x[j + k]
        x[j] = f


@kernel
def subtract_product(linear, x, y, out, out_border):
    """Subtract the matrix times (x, y) from (out, out_border); padding stays zero."""
    band, border, corner = linear
    rows, stride = band.shape
    n = rows - stride + 1
    m = corner.shape[0]
    for j in range(n):
        f = band[j, 0] * x[j]
        for k in range(1, stride):
            f += band[j, k] * x[j + k]
            out[j + k] -= band[j, k] * x[j]
        for k in range(m):
            f += border[j, k] * y[k]
            out_border[k] -= border[j, k] * x[j]
        out[j] -= f
    for k in range(m):
        for i in range(m):
            out_border[k] -= corner[k, i] * y[i]


@kernel
def solve_refined(linear, factor):
    """Solve for ``factor.rhs, factor.rhs_border`` in place, with one step of iterative refinement.

    The factorisation does not pivot; what it loses to a small pivot, this gives back.
    """
    right, right_border = factor.right, factor.right_border
    right[:] = factor.rhs
    right_border[:] = factor.rhs_border
    solve(factor, factor.rhs, factor.rhs_border)
    subtract_product(linear, factor.rhs, factor.rhs_border, right, right_border)
    solve(factor, right, right_border)
    factor.rhs[:] += right
    factor.rhs_border[:] += right_border
