"""The elements' linearisation: stages eliminated, what is left relates an element's two ends.

Inputs z of an element, 14: its left state (w, q, n) and (c_x, c_z, u3, sigma). Stage places and
forces are explicit in the stage quaternions, dW = Wz z + h A E dQ, dN = Nz z + h^2 A A H E dQ, so
that only the quaternion equations are solved, 4 m unknowns an element.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from derod.branches.element import INPUTS, stages, tangent_derivative
from derod.branches.gauss import MATRIX, STAGES, WEIGHTS

_M = STAGES
_A = MATRIX
_B = WEIGHTS


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
def _rates_by_inputs(q, L, W, N, Wz, Nz, k3, Pz):  # type: ignore[no-untyped-def]
    """Derivative Pz (4, 15) of one stage's q' by the inputs; dm = dc + N x dW - W x dN."""
    for z in range(INPUTS):
        w0, w1, w2 = Wz[0, z], Wz[1, z], Wz[2, z]
        n0, n1, n2 = Nz[0, z], Nz[1, z], Nz[2, z]
        m0 = N[1] * w2 - N[2] * w1 - W[1] * n2 + W[2] * n1
        m1 = N[2] * w0 - N[0] * w2 - W[2] * n0 + W[0] * n2
        m2 = N[0] * w1 - N[1] * w0 - W[0] * n1 + W[1] * n0
        if z == 10:
            m0 += 1.0
        if z == 11:
            m2 += 1.0
        for a in range(4):
            Pz[a, z] = L[a, 0] * m0 + L[a, 1] * m1 + L[a, 2] * m2
    half_k = 0.5 * (1.0 - k3)
    Pz[0, 12] -= half_k * q[3]
    Pz[1, 12] += half_k * q[2]
    Pz[2, 12] -= half_k * q[1]
    Pz[3, 12] += half_k * q[0]


@njit(cache=True, error_model="numpy", inline="always")
def _rates_by_stages(j, h, wet, L, W, N, H, E, T, C, CE, PQ):  # type: ignore[no-untyped-def]
    """Derivatives PQ (m, 4, 4) of stage j's q' by all stage quaternions, through m alone."""
    for other in range(_M):
        f = h * _A[j, other]
        C[0, 0], C[0, 1], C[0, 2] = 0.0, -f * N[2], f * N[1]
        C[1, 0], C[1, 1], C[1, 2] = f * N[2], 0.0, -f * N[0]
        C[2, 0], C[2, 1], C[2, 2] = -f * N[1], f * N[0], 0.0
        if wet:
            for a in range(3):
                for b in range(3):
                    total = 0.0
                    for k in range(_M):
                        total += _A[j, k] * _A[k, other] * H[k, a, b]
                    T[a, b] = h * h * total
            for b in range(3):
                C[0, b] -= W[1] * T[2, b] - W[2] * T[1, b]
                C[1, b] -= W[2] * T[0, b] - W[0] * T[2, b]
                C[2, b] -= W[0] * T[1, b] - W[1] * T[0, b]
        for a in range(3):
            for b in range(4):
                CE[a, b] = (
                    C[a, 0] * E[other, 0, b] + C[a, 1] * E[other, 1, b] + C[a, 2] * E[other, 2, b]
                )
        for a in range(4):
            for b in range(4):
                PQ[other, a, b] = L[a, 0] * CE[0, b] + L[a, 1] * CE[1, b] + L[a, 2] * CE[2, b]


@njit(cache=True, error_model="numpy", inline="always")
def _add_own_rate(m, twist, own):  # type: ignore[no-untyped-def]
    """Add to own (4, 4) the matrix of q to (m q + twist q e_3)/2."""
    m0, m1, m2 = 0.5 * m[0], 0.5 * m[1], 0.5 * m[2]
    t = 0.5 * twist
    own[0, 1] -= m0
    own[0, 2] -= m1
    own[0, 3] -= m2 + t
    own[1, 0] += m0
    own[1, 2] += t - m2
    own[1, 3] += m1
    own[2, 0] += m1
    own[2, 1] += m2 - t
    own[2, 3] -= m0
    own[3, 0] += m2 + t
    own[3, 1] -= m1
    own[3, 2] += m0


@njit(cache=True, error_model="numpy")
def _solve_in_place(S, X, size, columns):  # type: ignore[no-untyped-def]
    """Gaussian elimination with row pivoting: X := S^-1 X, S is destroyed."""
    for c in range(size):
        best = c
        for r in range(c + 1, size):
            if abs(S[r, c]) > abs(S[best, c]):
                best = r
        if best != c:
            for k in range(c, size):
                S[c, k], S[best, k] = S[best, k], S[c, k]
            for k in range(columns):
                X[c, k], X[best, k] = X[best, k], X[c, k]
        inverse = 1.0 / S[c, c]
        for r in range(c + 1, size):
            factor = S[r, c] * inverse
            if factor != 0.0:
                for k in range(c + 1, size):
                    S[r, k] -= factor * S[c, k]
                for k in range(columns):
                    X[r, k] -= factor * X[c, k]
    for r in range(size - 1, -1, -1):
        inverse = 1.0 / S[r, r]
        for k in range(columns):
            X[r, k] *= inverse
        for above in range(r):
            factor = S[above, r]
            if factor != 0.0:
                for k in range(columns):
                    X[above, k] -= factor * X[r, k]


@njit(cache=True, error_model="numpy", inline="always")
def _stage_equations(y, Q, P, Pz, PQ, h, dh, S, x):  # type: ignore[no-untyped-def]
    """Matrix S, right-hand sides x of Q_j = q + h sum_k A_jk P_k; returns the largest residual."""
    worst = 0.0
    for j in range(_M):
        for a in range(4):
            row = 4 * j + a
            for other in range(_M):
                for b in range(4):
                    total = 0.0
                    for k in range(_M):
                        total += _A[j, k] * PQ[k, other, a, b]
                    S[row, 4 * other + b] = -h * total
            S[row, row] += 1.0
            mean = 0.0
            for k in range(_M):
                mean += _A[j, k] * P[k, a]
            for z in range(INPUTS):
                total = 0.0
                for k in range(_M):
                    total += _A[j, k] * Pz[k, a, z]
                x[row, z] = h * total
            x[row, 3 + a] += 1.0
            x[row, 13] += dh * mean
            residual = y[3 + a] + h * mean - Q[j, a]
            x[row, INPUTS] = residual
            worst = max(worst, abs(residual))
    return worst


@njit(cache=True, error_model="numpy", inline="always")
def _right_place_and_force(y, right, D, G, H, E, x, h, dh, wet, Wz, A, r):  # type: ignore[no-untyped-def]
    """Rows w and n of the end map; column INPUTS of x and Wz is the stages' own Newton step."""
    for j in range(_M):
        for a in range(3):
            for z in range(INPUTS + 1):
                total = 0.0
                for k in range(_M):
                    f = _A[j, k]
                    for b in range(4):
                        total += f * E[k, a, b] * x[4 * k + b, z]
                Wz[j, a, z] += h * total
    for a in range(3):
        for z in range(INPUTS + 1):
            total = 0.0
            for k in range(_M):
                for b in range(4):
                    total += _B[k] * E[k, a, b] * x[4 * k + b, z]
            if z < INPUTS:
                A[a, z] = h * total
            else:
                r[a] = h * total
            total = 0.0
            if wet:
                for k in range(_M):
                    for b in range(3):
                        total += _B[k] * H[k, a, b] * Wz[k, b, z]
            if z < INPUTS:
                A[7 + a, z] = h * total
            else:
                r[7 + a] = h * total
        A[a, a] += 1.0
        A[7 + a, 7 + a] += 1.0
        speed = 0.0
        force = 0.0
        for k in range(_M):
            speed += _B[k] * D[k, a]
            if wet:
                force += _B[k] * G[k, a]
        A[a, 13] += dh * speed
        A[7 + a, 13] += dh * force
        r[a] += y[a] + h * speed - right[a]
        r[7 + a] += y[7 + a] + h * force - right[7 + a]


@njit(cache=True, error_model="numpy", inline="always")
def _right_quaternion(y, right, P, Pz, PQ, x, h, dh, A, r):  # type: ignore[no-untyped-def]
    """Rows q of the end map."""
    for a in range(4):
        for z in range(INPUTS + 1):
            total = 0.0
            for k in range(_M):
                if z < INPUTS:
                    total += _B[k] * Pz[k, a, z]
                for other in range(_M):
                    for b in range(4):
                        total += _B[k] * PQ[k, other, a, b] * x[4 * other + b, z]
            if z < INPUTS:
                A[3 + a, z] = h * total
            else:
                r[3 + a] = h * total
        A[3 + a, 3 + a] += 1.0
        rate = 0.0
        for k in range(_M):
            rate += _B[k] * P[k, a]
        A[3 + a, 13] += dh * rate
        r[3 + a] += y[3 + a] + h * rate - right[3 + a]


@njit(cache=True, error_model="numpy")
def condense(nodes, Q, eta, inner, half, p, k3, strength, softness, A, r, X):  # type: ignore[no-untyped-def]
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
    E, PQ = np.empty((_M, 3, 4)), np.empty((_M, _M, 4, 4))
    Wz, Nz = np.empty((_M, 3, INPUTS + 1)), np.empty((_M, 3, INPUTS + 1))
    Pz = np.empty((_M, 4, INPUTS + 1))
    T, C, CE, L = np.empty((3, 3)), np.empty((3, 3)), np.empty((3, 4)), np.empty((4, 3))
    S = np.empty((4 * _M, 4 * _M))
    gap = 1.0
    worst = 0.0
    twist = (1.0 - k3) * p[2]
    for e in range(eta.size):
        wet = e < inner
        left = e if wet else e + 1
        h = eta[e] * (p[3] if wet else half - p[3])
        dh = eta[e] if wet else -eta[e]
        y, right = nodes[left], nodes[left + 1]
        gap = min(gap, stages(y, Q[e], h, p, k3, strength, softness, wet, D, W, G, H, N, Mm, P))
        for k in range(_M):
            tangent_derivative(Q[e, k], E[k])
        _explicit_inputs(D, G, H, h, dh, wet, Wz, Nz)
        for j in range(_M):
            _quaternion_product(Q[e, j], L)
            _rates_by_inputs(Q[e, j], L, W[j], N[j], Wz[j], Nz[j], k3, Pz[j])
            _rates_by_stages(j, h, wet, L, W[j], N[j], H, E, T, C, CE, PQ[j])
            _add_own_rate(Mm[j], twist, PQ[j, j])
        worst = max(worst, _stage_equations(y, Q[e], P, Pz, PQ, h, dh, S, X[e]))
        _solve_in_place(S, X[e], 4 * _M, INPUTS + 1)
        _right_place_and_force(y, right, D, G, H, E, X[e], h, dh, wet, Wz, A[e], r[e])
        _right_quaternion(y, right, P, Pz, PQ, X[e], h, dh, A[e], r[e])
    return gap, worst
