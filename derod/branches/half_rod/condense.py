"""The elements' linearisation: stages eliminated, what is left relates an element's two ends.

Inputs z of an element, 14: its left state (w, q, n) and (c_x, c_z, u3, sigma). Stage places and
forces are explicit in the stage quaternions, dW = Wz z + h A E dQ, dN = Nz z + h^2 A A H E dQ, so
that only the quaternion equations are solved, 4 m unknowns an element. Arrays are laid out so that the
innermost loops run over an element's 4 m stage unknowns or its 15 right-hand sides.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from derod.branches.half_rod.element import INPUTS, stages, tangent_derivative
from derod.branches.half_rod.gauss import MATRIX, STAGES, WEIGHTS
from derod.branches.half_rod.section import (
    add_section_by_frame,
    add_section_by_moment,
    anisotropic,
    local_twist,
)

_M = STAGES
_A = MATRIX
_B = WEIGHTS
_S = 4 * STAGES  # stage unknowns
_R = INPUTS + 1  # right-hand sides: the inputs, and the stages' own Newton step
_P = _S + _R


@njit(cache=True, error_model="numpy", inline="always")
def _explicit_inputs(D, G, H, h, dh, wet, Wz, Nz):  # type: ignore[no-untyped-def]
    """Derivatives Wz, Nz (m, 3, 15) of stage places and forces by the inputs, quaternions held."""
    Wz[:] = 0.0
    Nz[:] = 0.0
    for j in range(_M):
        for i in range(3):
            Wz[j, i, i] = 1.0
            total = 0.0
            for k in range(_M):
                total += _A[j, k] * D[k, i]
            Wz[j, i, 13] = dh * total
    for j in range(_M):
        for i in range(3):
            Nz[j, i, 7 + i] = 1.0
            if wet:
                for k in range(_M):
                    Nz[j, i, 13] += dh * _A[j, k] * G[k, i]
                    for b in range(3):
                        Nz[j, i, b] += h * _A[j, k] * H[k, i, b]
                        Nz[j, i, 13] += h * _A[j, k] * H[k, i, b] * Wz[k, b, 13]


@njit(cache=True, error_model="numpy", inline="always")
def _quaternion_product(q, L):  # type: ignore[no-untyped-def]
    """L (4, 3): v to the quaternion product v q / 2."""
    L[0, 0], L[0, 1], L[0, 2] = -0.5 * q[1], -0.5 * q[2], -0.5 * q[3]
    L[1, 0], L[1, 1], L[1, 2] = 0.5 * q[0], 0.5 * q[3], -0.5 * q[2]
    L[2, 0], L[2, 1], L[2, 2] = -0.5 * q[3], 0.5 * q[0], 0.5 * q[1]
    L[3, 0], L[3, 1], L[3, 2] = 0.5 * q[2], -0.5 * q[1], 0.5 * q[0]


@njit(cache=True, error_model="numpy", inline="always")
def _rates_by_inputs(q, L, W, N, Wz, Nz, twisted, m, Pz):  # type: ignore[no-untyped-def]
    """Derivative Pz (4, 15) of one stage's q' by the inputs; dm = dc + N x dW - W x dN in m (3, 15).

    ``twisted``: derivative of the twist by u3, 1 - k3 where u3 is uniform.
    """
    for z in range(_R):
        m[0, z] = N[1] * Wz[2, z] - N[2] * Wz[1, z] - W[1] * Nz[2, z] + W[2] * Nz[1, z]
    for z in range(_R):
        m[1, z] = N[2] * Wz[0, z] - N[0] * Wz[2, z] - W[2] * Nz[0, z] + W[0] * Nz[2, z]
    for z in range(_R):
        m[2, z] = N[0] * Wz[1, z] - N[1] * Wz[0, z] - W[0] * Nz[1, z] + W[1] * Nz[0, z]
    m[0, 10] += 1.0
    m[2, 11] += 1.0
    for a in range(4):
        for z in range(_R):
            Pz[a, z] = L[a, 0] * m[0, z] + L[a, 1] * m[1, z] + L[a, 2] * m[2, z]
    half_k = 0.5 * twisted
    Pz[0, 12] -= half_k * q[3]
    Pz[1, 12] += half_k * q[2]
    Pz[2, 12] -= half_k * q[1]
    Pz[3, 12] += half_k * q[0]


@njit(cache=True, error_model="numpy", inline="always")
def _rates_by_stages(j, h, wet, L, W, N, H, E, T, C, CE, PQ):  # type: ignore[no-untyped-def]
    """Derivatives PQ (4, 4 m) of stage j's q' by all stage quaternions, through m alone."""
    for other in range(_M):
        f = h * _A[j, other]
        C[0, 0], C[0, 1], C[0, 2] = 0.0, -f * N[2], f * N[1]
        C[1, 0], C[1, 1], C[1, 2] = f * N[2], 0.0, -f * N[0]
        C[2, 0], C[2, 1], C[2, 2] = -f * N[1], f * N[0], 0.0
        if wet:
            T[:] = 0.0
            for k in range(_M):
                g = h * h * _A[j, k] * _A[k, other]
                for a in range(3):
                    for b in range(3):
                        T[a, b] += g * H[k, a, b]
            for b in range(3):
                C[0, b] -= W[1] * T[2, b] - W[2] * T[1, b]
                C[1, b] -= W[2] * T[0, b] - W[0] * T[2, b]
                C[2, b] -= W[0] * T[1, b] - W[1] * T[0, b]
        for a in range(3):
            for b in range(4):
                CE[a, 4 * other + b] = (
                    C[a, 0] * E[other, 0, b] + C[a, 1] * E[other, 1, b] + C[a, 2] * E[other, 2, b]
                )
    for a in range(4):
        for b in range(_S):
            PQ[a, b] = L[a, 0] * CE[0, b] + L[a, 1] * CE[1, b] + L[a, 2] * CE[2, b]


@njit(cache=True, error_model="numpy", inline="always")
def _add_own_rate(m, twist, first, PQ):  # type: ignore[no-untyped-def]
    """Add to PQ (4, 4 m), from column ``first``, the matrix of q to (m q + twist q e_3)/2."""
    m0, m1, m2 = 0.5 * m[0], 0.5 * m[1], 0.5 * m[2]
    t = 0.5 * twist
    PQ[0, first + 1] -= m0
    PQ[0, first + 2] -= m1
    PQ[0, first + 3] -= m2 + t
    PQ[1, first] += m0
    PQ[1, first + 2] += t - m2
    PQ[1, first + 3] += m1
    PQ[2, first] += m1
    PQ[2, first + 1] += m2 - t
    PQ[2, first + 3] -= m0
    PQ[3, first] += m2 + t
    PQ[3, first + 1] -= m1
    PQ[3, first + 2] += m0


@njit(cache=True, error_model="numpy", inline="always")
def _solve_stages(T):  # type: ignore[no-untyped-def]
    """Gaussian elimination with row pivoting of T (4 m, 4 m + 15): its last columns := S^-1 x."""
    for c in range(_S):
        best = c
        for r in range(c + 1, _S):
            if abs(T[r, c]) > abs(T[best, c]):
                best = r
        if best != c:
            for k in range(c, _P):
                T[c, k], T[best, k] = T[best, k], T[c, k]
        inverse = 1.0 / T[c, c]
        for r in range(c + 1, _S):
            factor = T[r, c] * inverse
            if factor != 0.0:
                for k in range(c + 1, _P):
                    T[r, k] -= factor * T[c, k]
    for r in range(_S - 1, -1, -1):
        inverse = 1.0 / T[r, r]
        for k in range(_S, _P):
            T[r, k] *= inverse
        for above in range(r):
            factor = T[above, r]
            for k in range(_S, _P):
                T[above, k] -= factor * T[r, k]


@njit(cache=True, error_model="numpy", inline="always")
def _stage_equations(y, Q, P, Pz, PQ, h, dh, T):  # type: ignore[no-untyped-def]
    """Matrix and right-hand sides T (4 m, 4 m + 15) of Q_j = q + h sum_k A_jk P_k.

    Returns the largest residual.
    """
    worst = 0.0
    for j in range(_M):
        for a in range(4):
            row = T[4 * j + a]
            row[:] = 0.0
            mean = 0.0
            for k in range(_M):
                f = h * _A[j, k]
                mean += _A[j, k] * P[k, a]
                for b in range(_S):
                    row[b] -= f * PQ[k, a, b]
                for z in range(_R):
                    row[_S + z] += f * Pz[k, a, z]
            row[4 * j + a] += 1.0
            row[_S + 3 + a] += 1.0
            row[_S + 13] += dh * mean
            residual = y[3 + a] + h * mean - Q[j, a]
            row[_S + INPUTS] = residual
            worst = max(worst, abs(residual))
    return worst


@njit(cache=True, error_model="numpy", inline="always")
def _ends_by_stages(E, H, PQ, h, wet, T, ends):  # type: ignore[no-untyped-def]
    """Derivative ``ends`` (10, 4 m) of the right end (w, q, n) by the stage quaternions."""
    ends[:] = 0.0
    for k in range(_M):
        for a in range(3):
            for b in range(4):
                ends[a, 4 * k + b] = h * _B[k] * E[k, a, b]
        for a in range(4):
            for b in range(_S):
                ends[3 + a, b] += h * _B[k] * PQ[k, a, b]
    if wet:
        for k in range(_M):
            T[:] = 0.0
            for j in range(_M):
                g = h * h * _B[j] * _A[j, k]
                for a in range(3):
                    for b in range(3):
                        T[a, b] += g * H[j, a, b]
            for a in range(3):
                for b in range(4):
                    ends[7 + a, 4 * k + b] = (
                        T[a, 0] * E[k, 0, b] + T[a, 1] * E[k, 1, b] + T[a, 2] * E[k, 2, b]
                    )


@njit(cache=True, error_model="numpy", inline="always")
def _right_end(y, right, D, G, H, P, Pz, Wz, ends, X, h, dh, wet, row, A, r):  # type: ignore[no-untyped-def]
    """The end map A (10, 14) and its residual r (10,)."""
    for a in range(10):
        row[:] = 0.0
        row[a] = 1.0
        value = 0.0
        for k in range(_M):
            f = h * _B[k]
            if a < 3:
                value += _B[k] * D[k, a]
            elif a < 7:
                value += _B[k] * P[k, a - 3]
                for z in range(_R):
                    row[z] += f * Pz[k, a - 3, z]
            elif wet:
                value += _B[k] * G[k, a - 7]
                for b in range(3):
                    g = f * H[k, a - 7, b]
                    for z in range(_R):
                        row[z] += g * Wz[k, b, z]
        for s in range(_S):
            f = ends[a, s]
            for z in range(_R):
                row[z] += f * X[s, z]
        row[13] += dh * value
        for z in range(INPUTS):
            A[a, z] = row[z]
        r[a] = row[INPUTS] + y[a] + h * value - right[a]


@njit(cache=True, error_model="numpy")
def condense(nodes, Q, eta, inner, half, p, section, strength, softness, A, r, X):  # type: ignore[no-untyped-def]
    """Linearise every element and eliminate its stages.

    nodes (E+2, 10): inner nodes first, then the outer ones (the meniscus twice: before and after
    the jump). Q (E, m, 4) stage quaternions, eta (E,) element lengths as fractions of their
    interval, inner the number of wetted elements, half = l/2, p = (c_x, c_z, u3, sigma). Writes A
    (E, 10, 14): derivative of the right end state with respect to the left end state and p; r (E,
    10): right end state of the linearised stages minus the right node; X (E, 4m, 15): derivative
    of the stages with respect to the same 14 inputs and, last, their own Newton step. Returns
    (least gap, largest stage residual).
    """
    D, W, N, Mm = np.empty((_M, 3)), np.empty((_M, 3)), np.empty((_M, 3)), np.empty((_M, 3))
    G, H, P = np.zeros((_M, 3)), np.zeros((_M, 3, 3)), np.empty((_M, 4))
    E, PQ = np.empty((_M, 3, 4)), np.empty((_M, 4, _S))
    Wz, Nz = np.empty((_M, 3, _R)), np.empty((_M, 3, _R))
    Pz, dm = np.empty((_M, 4, _R)), np.empty((3, _R))
    T, C, CE, L = np.empty((3, 3)), np.empty((3, 3)), np.empty((3, _S)), np.empty((4, 3))
    system, ends, row = np.empty((_S, _P)), np.empty((10, _S)), np.empty(_R)
    gap = 1.0
    worst = 0.0
    two = anisotropic(section)
    twisted = 0.0 if two else 1.0 - section[0]
    twist = twisted * p[2]
    for e in range(eta.size):
        wet = e < inner
        left = e if wet else e + 1
        h = eta[e] * (p[3] if wet else half - p[3])
        dh = eta[e] if wet else -eta[e]
        y, right = nodes[left], nodes[left + 1]
        own = stages(y, Q[e], h, p, section, strength, softness, wet, D, W, G, H, N, Mm, P)
        gap = min(gap, own)
        for k in range(_M):
            tangent_derivative(Q[e, k], E[k])
        _explicit_inputs(D, G, H, h, dh, wet, Wz, Nz)
        for j in range(_M):
            _quaternion_product(Q[e, j], L)
            if two:
                twist = local_twist(Mm[j], section, D[j])
                add_section_by_moment(section, Q[e, j], D[j], L)
            _rates_by_inputs(Q[e, j], L, W[j], N[j], Wz[j], Nz[j], twisted, dm, Pz[j])
            _rates_by_stages(j, h, wet, L, W[j], N[j], H, E, T, C, CE, PQ[j])
            _add_own_rate(Mm[j], twist, 4 * j, PQ[j])
            if two:
                add_section_by_frame(Mm[j], section, Q[e, j], 4 * j, PQ[j])
        worst = max(worst, _stage_equations(y, Q[e], P, Pz, PQ, h, dh, system))
        _solve_stages(system)
        for s in range(_S):
            for z in range(_R):
                X[e, s, z] = system[s, _S + z]
        _ends_by_stages(E, H, PQ, h, wet, T, ends)
        _right_end(y, right, D, G, H, P, Pz, Wz, ends, X[e], h, dh, wet, row, A[e], r[e])
    return gap, worst
