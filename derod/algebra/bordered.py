"""LDL^T of a symmetric indefinite band with a border, and its inertia, in O(n).

    [[K, B], [B^T, C]],   K = L D L^T,   S = C - B^T K^{-1} B

K is factored without pivoting: each multiplier comes after its edge's nodes, so that a pivot only
vanishes by accident; the factor is then not finite, and says so. By Sylvester's law the whole matrix
has as many negative eigenvalues as D and S together. Zero blocks stay exactly zero: a planar state gets
no force out of its plane.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from derod.algebra.copying import copy_rows, copy_vector
from derod.algebra.dense import invert
from derod.algebra.jit import inlined, kernel


class Factor(NamedTuple):
    """A factored bordered band matrix."""

    lower: np.ndarray  # (n + w, w + 1): D on lower[:, 0], L's columns beside it
    half: np.ndarray  # (n + w, m): L^{-1} B
    scale: np.ndarray  # (m,) that makes S's rows comparable
    schur: np.ndarray  # (m, m) the inverse of S, scaled
    scaled: np.ndarray  # (m,) room
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
        np.zeros(borders),
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
    copy_rows(linear.band, lower)
    copy_rows(linear.border, half)
    copy_rows(linear.corner, schur)
    negative = 0
    for j in range(n):
        pivot = lower[j, 0]
        negative += pivot < 0
        inverse = 1.0 / pivot
        for k in range(1, stride):
            f = lower[j, k] * inverse
            if f == 0.0:
                continue
            for i in range(stride - k):
                lower[j + k, i] -= f * lower[j, k + i]
            for i in range(m):
                half[j + k, i] -= f * half[j, i]
        for k in range(1, stride):
            lower[j, k] *= inverse
        for k in range(m):
            f = half[j, k] * inverse
            for i in range(m):
                schur[k, i] -= f * half[j, i]
    for k in range(m):
        largest = 0.0
        for i in range(m):
            largest = max(largest, abs(schur[k, i]))
        factor.scale[k] = 1.0 / math.sqrt(largest + 1e-300)
    for k in range(m):
        for i in range(m):
            schur[k, i] *= factor.scale[k] * factor.scale[i]
    more = invert(schur, factor.scaled)
    return negative + more if more >= 0 else -1


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
    solve_border(factor, y)
    x[n:] = 0.0
    for j in range(n - 1, -1, -1):
        f = x[j]
        for k in range(m):
            f -= half[j, k] * y[k]
        f /= lower[j, 0]
        for k in range(1, stride):
            f -= lower[j, k] * x[j + k]
        x[j] = f


@inlined
def solve_border(factor, y):
    """Solve S y = y in place."""
    m = y.size
    scaled = factor.scaled
    for k in range(m):
        scaled[k] = factor.scale[k] * y[k]
    for k in range(m):
        total = 0.0
        for i in range(m):
            total += factor.schur[k, i] * scaled[i]
        y[k] = factor.scale[k] * total


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
    copy_vector(factor.rhs, right)
    copy_vector(factor.rhs_border, right_border)
    solve(factor, factor.rhs, factor.rhs_border)
    subtract_product(linear, factor.rhs, factor.rhs_border, right, right_border)
    solve(factor, right, right_border)
    for j in range(right.size):
        factor.rhs[j] += right[j]
    for k in range(right_border.size):
        factor.rhs_border[k] += right_border[k]
