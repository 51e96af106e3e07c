"""One collocation element of the half-rod equations, condensed to its two end states.

State at a node, 10 numbers: w = r - r_C (3), q (4), n (3). The frame of eq:18d-equilibre is
carried by the unit quaternion q = (q_w, q_x, q_y, q_z), d_i = q e_i q*, so that d_3' = m x d_3
and d_1' = (m + (1 - k3) u3 d_3) x d_1 become

    q' = (m q + (1 - k3) u3 q e_3) / 2,      w' = d_3(q),      n' = chi grad v(w).

The moment is not integrated: c = m + w x n is conserved (the meniscus force is radial), c_y = 0
by the flip symmetry, u3 is uniform (equa_M3). Hence m = c - w x n with the four element
parameters (c_x, c_z, u3, sigma), sigma entering through the element's length. Gauss collocation
keeps |q| = 1.

In an element only the stage quaternions Q_k are unknowns: W_k and N_k follow from them explicitly.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from derod.branches.gauss import MATRIX, STAGES, WEIGHTS

STATE = 10
PARAMETERS = 4  # c_x, c_z, u3, sigma
INPUTS = STATE + PARAMETERS
_M = STAGES
_A = MATRIX
_B = WEIGHTS


@njit(cache=True, error_model="numpy")
def tangent(q, out):  # type: ignore[no-untyped-def]
    """d_3(q) into out (3,)."""
    out[0] = 2.0 * (q[1] * q[3] + q[0] * q[2])
    out[1] = 2.0 * (q[2] * q[3] - q[0] * q[1])
    out[2] = q[0] * q[0] - q[1] * q[1] - q[2] * q[2] + q[3] * q[3]


@njit(cache=True, error_model="numpy")
def tangent_derivative(q, out):  # type: ignore[no-untyped-def]
    """The derivative of d_3 with respect to q into out (3, 4)."""
    w, x, y, z = 2.0 * q[0], 2.0 * q[1], 2.0 * q[2], 2.0 * q[3]
    out[0, 0], out[0, 1], out[0, 2], out[0, 3] = y, z, w, x
    out[1, 0], out[1, 1], out[1, 2], out[1, 3] = -x, -w, z, y
    out[2, 0], out[2, 1], out[2, 2], out[2, 3] = w, -x, -y, z


@njit(cache=True, error_model="numpy")
def wall_gradient(w, strength, softness, grad, hess):  # type: ignore[no-untyped-def]
    """Gradient (3,) and Hessian (3, 3) of v = v0/(1 + rho - 2 |w|); returns the gap 1 + rho - 2
    |w|.

    The cone at w = 0 is met only in the limit: Gauss points never lie on a node.
    """
    r = np.sqrt(w[0] * w[0] + w[1] * w[1] + w[2] * w[2])
    gap = 1.0 + softness - 2.0 * r
    if r < 1e-200:
        r = 1e-200
    slope = 2.0 * strength / (gap * gap)
    across = slope / r
    along = 4.0 * slope / gap - across
    for i in range(3):
        grad[i] = across * w[i]
        for j in range(3):
            hess[i, j] = along * (w[i] / r) * (w[j] / r)
        hess[i, i] += across
    return gap


@njit(cache=True, error_model="numpy")
def moment(cx, cz, w, n, out):  # type: ignore[no-untyped-def]
    """m = c - w x n into out (3,)."""
    out[0] = cx - (w[1] * n[2] - w[2] * n[1])
    out[1] = -(w[2] * n[0] - w[0] * n[2])
    out[2] = cz - (w[0] * n[1] - w[1] * n[0])


@njit(cache=True, error_model="numpy")
def quaternion_rate(m, twist, q, out):  # type: ignore[no-untyped-def]
    """q' = (m q + twist q e_3)/2 into out (4,), twist = (1 - k3) u3."""
    out[0] = 0.5 * (-m[0] * q[1] - m[1] * q[2] - m[2] * q[3] - twist * q[3])
    out[1] = 0.5 * (m[0] * q[0] + m[1] * q[3] - m[2] * q[2] + twist * q[2])
    out[2] = 0.5 * (m[1] * q[0] + m[2] * q[1] - m[0] * q[3] - twist * q[1])
    out[3] = 0.5 * (m[2] * q[0] + m[0] * q[2] - m[1] * q[1] + twist * q[0])


@njit(cache=True, error_model="numpy")
def stages(y, Q, h, p, k3, strength, softness, wet, D, W, G, H, N, Mm, P):  # type: ignore[no-untyped-def]
    """Stage tangents, places, wall forces, forces, moments and quaternion rates; returns the
    least gap."""
    gap = 1.0
    for k in range(_M):
        tangent(Q[k], D[k])
    for j in range(_M):
        for i in range(3):
            total = 0.0
            for k in range(_M):
                total += _A[j, k] * D[k, i]
            W[j, i] = y[i] + h * total
        if wet:
            gap = min(gap, wall_gradient(W[j], strength, softness, G[j], H[j]))
    for j in range(_M):
        for i in range(3):
            total = 0.0
            if wet:
                for k in range(_M):
                    total += _A[j, k] * G[k, i]
            N[j, i] = y[7 + i] + h * total
        moment(p[0], p[1], W[j], N[j], Mm[j])
        quaternion_rate(Mm[j], (1.0 - k3) * p[2], Q[j], P[j])
    return gap


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
    D = np.empty((_M, 3))
    W = np.empty((_M, 3))
    G = np.zeros((_M, 3))
    H = np.zeros((_M, 3, 3))
    N = np.empty((_M, 3))
    Mm = np.empty((_M, 3))
    P = np.empty((_M, 4))
    E = np.empty((_M, 3, 4))
    Wz = np.empty((_M, 3, INPUTS + 1))
    Nz = np.empty((_M, 3, INPUTS + 1))
    Pz = np.empty((_M, 4, INPUTS + 1))
    PQ = np.empty((_M, _M, 4, 4))
    T = np.empty((3, 3))
    C = np.empty((3, 3))
    CE = np.empty((3, 4))
    L = np.empty((4, 3))
    S = np.empty((4 * _M, 4 * _M))
    gap = 1.0
    worst = 0.0
    twist = (1.0 - k3) * p[2]
    for e in range(eta.size):
        wet = e < inner
        left = e if wet else e + 1
        h = eta[e] * (p[3] if wet else half - p[3])
        dh = eta[e] if wet else -eta[e]
        y = nodes[left]
        gap = min(gap, stages(y, Q[e], h, p, k3, strength, softness, wet, D, W, G, H, N, Mm, P))
        for k in range(_M):
            tangent_derivative(Q[e, k], E[k])
        # explicit part of dW, dN: the inputs w, n and sigma
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
        # rates: dP_j = Pz_j z + sum_l PQ_jl dQ_l
        for j in range(_M):
            q = Q[e, j]
            L[0, 0], L[0, 1], L[0, 2] = -0.5 * q[1], -0.5 * q[2], -0.5 * q[3]
            L[1, 0], L[1, 1], L[1, 2] = 0.5 * q[0], 0.5 * q[3], -0.5 * q[2]
            L[2, 0], L[2, 1], L[2, 2] = -0.5 * q[3], 0.5 * q[0], 0.5 * q[1]
            L[3, 0], L[3, 1], L[3, 2] = 0.5 * q[2], -0.5 * q[1], 0.5 * q[0]
            for z in range(INPUTS):
                w0, w1, w2 = Wz[j, 0, z], Wz[j, 1, z], Wz[j, 2, z]
                n0, n1, n2 = Nz[j, 0, z], Nz[j, 1, z], Nz[j, 2, z]
                # dm = dc + N x dW - W x dN
                m0 = N[j, 1] * w2 - N[j, 2] * w1 - W[j, 1] * n2 + W[j, 2] * n1
                m1 = N[j, 2] * w0 - N[j, 0] * w2 - W[j, 2] * n0 + W[j, 0] * n2
                m2 = N[j, 0] * w1 - N[j, 1] * w0 - W[j, 0] * n1 + W[j, 1] * n0
                if z == 10:
                    m0 += 1.0
                if z == 11:
                    m2 += 1.0
                for a in range(4):
                    Pz[j, a, z] = L[a, 0] * m0 + L[a, 1] * m1 + L[a, 2] * m2
            half_k = 0.5 * (1.0 - k3)
            Pz[j, 0, 12] -= half_k * q[3]
            Pz[j, 1, 12] += half_k * q[2]
            Pz[j, 2, 12] -= half_k * q[1]
            Pz[j, 3, 12] += half_k * q[0]
            for other in range(_M):
                f = h * _A[j, other]
                C[0, 0], C[0, 1], C[0, 2] = 0.0, -f * N[j, 2], f * N[j, 1]
                C[1, 0], C[1, 1], C[1, 2] = f * N[j, 2], 0.0, -f * N[j, 0]
                C[2, 0], C[2, 1], C[2, 2] = -f * N[j, 1], f * N[j, 0], 0.0
                if wet:
                    for a in range(3):
                        for b in range(3):
                            total = 0.0
                            for k in range(_M):
                                total += _A[j, k] * _A[k, other] * H[k, a, b]
                            T[a, b] = h * h * total
                    for b in range(3):
                        C[0, b] -= W[j, 1] * T[2, b] - W[j, 2] * T[1, b]
                        C[1, b] -= W[j, 2] * T[0, b] - W[j, 0] * T[2, b]
                        C[2, b] -= W[j, 0] * T[1, b] - W[j, 1] * T[0, b]
                for a in range(3):
                    for b in range(4):
                        CE[a, b] = (
                            C[a, 0] * E[other, 0, b]
                            + C[a, 1] * E[other, 1, b]
                            + C[a, 2] * E[other, 2, b]
                        )
                for a in range(4):
                    for b in range(4):
                        PQ[j, other, a, b] = (
                            L[a, 0] * CE[0, b] + L[a, 1] * CE[1, b] + L[a, 2] * CE[2, b]
                        )
            m0, m1, m2 = 0.5 * Mm[j, 0], 0.5 * Mm[j, 1], 0.5 * Mm[j, 2]
            t = 0.5 * twist
            own = PQ[j, j]
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
        # stage equations Q_j = q + h sum_k A_jk P_k, linearised
        x = X[e]
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
                residual = y[3 + a] + h * mean - Q[e, j, a]
                x[row, INPUTS] = residual
                worst = max(worst, abs(residual))
        _solve_in_place(S, x, 4 * _M, INPUTS + 1)
        # right end, column INPUTS is the part due to the stages' own step
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
                    A[e, a, z] = h * total
                else:
                    r[e, a] = h * total
                total = 0.0
                if wet:
                    for k in range(_M):
                        for b in range(3):
                            total += _B[k] * H[k, a, b] * Wz[k, b, z]
                if z < INPUTS:
                    A[e, 7 + a, z] = h * total
                else:
                    r[e, 7 + a] = h * total
            A[e, a, a] += 1.0
            A[e, 7 + a, 7 + a] += 1.0
            speed = 0.0
            force = 0.0
            for k in range(_M):
                speed += _B[k] * D[k, a]
                if wet:
                    force += _B[k] * G[k, a]
            A[e, a, 13] += dh * speed
            A[e, 7 + a, 13] += dh * force
            r[e, a] += y[a] + h * speed - nodes[left + 1, a]
            r[e, 7 + a] += y[7 + a] + h * force - nodes[left + 1, 7 + a]
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
                    A[e, 3 + a, z] = h * total
                else:
                    r[e, 3 + a] = h * total
            A[e, 3 + a, 3 + a] += 1.0
            rate = 0.0
            for k in range(_M):
                rate += _B[k] * P[k, a]
            A[e, 3 + a, 13] += dh * rate
            r[e, 3 + a] += y[3 + a] + h * rate - nodes[left + 1, 3 + a]
    return gap, worst
