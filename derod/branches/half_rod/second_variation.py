"""Second variation of the energy on half a rod, summed element by element from the clamp.

Variations of the whole rod at fixed clamps: frames turn by phi(s), the centre line moves by rho
with rho' = phi x d_3, the drop's centre by rho_C, the menisci by b along the rod. To second order
twice the Lagrangian (fixed multipliers n, f_B) is

    int [ phi'.K phi' - phi'.(m x phi) + (n.d_3)|phi|^2 - (n.phi)(d_3.phi) ] ds
      + int_wet eta.(grad grad v) eta ds,      eta = rho - rho_C,
      + 2 sum over menisci of f_B (|rho + b d_3 - rho_C|^2 + w.(b^2 d_3' + 2 b rho')) +- (b grad
      v.eta + b^2 grad v.d_3/2)

on the kernel of the constraints rho(0) = rho(l) = 0, phi = 0 at the clamps, w.(rho + b d_3 -
rho_C) = 0, by which b is eliminated. phi is piecewise quadratic and rho its exact integral, so this
is a Ritz method: it converges from above and needs no multiplier for inextensibility.

The sweep goes from the clamp to the middle with a front of twenty unknowns: an element's rotations
phi (left, middle, right), rho at its left end, rho_C, and five multipliers: rho(clamp) = 0 (3), the
turn about the clamp axis, the slide along the rod. rho at the right end is written as rho_left +
int phi x d_3: the dry part then has no zero pivot. The middle and right rotations leave after each
element. What is left at the middle serves flip-even and flip-odd variations alike.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from derod.branches.half_rod.closure import jump
from derod.branches.half_rod.element import moment, tangent
from derod.branches.half_rod.fields import evaluate_fields, section_fields
from derod.branches.half_rod.front import eliminate
from derod.branches.half_rod.gauss import MATRIX, NODES, STAGES, WEIGHTS
from derod.branches.half_rod.section import bending_strain
from derod.branches.half_rod.state import HalfRod
from derod.branches.half_rod.wall_core import CORE, cored_wall

RIGHT, RHO, CENTRE, CLAMP, TURN, SLIDE, SIZE = 6, 9, 12, 15, 18, 19, 20
"""Places in the front: phi at left, middle, right (from 0, 3, 6), rho, rho_C, multipliers."""
CLAMP_COMPLIANCE = 1e-10
"""Of rho(clamp) = 0: on a straight rod no variation moves along it, and its multiplier is idle."""
TURN_PENALTY = 1e2
"""On the turn about the clamp axis, as a vector of length one."""

SHAPE = np.stack(
    [(1 - NODES) * (1 - 2 * NODES), 4 * NODES * (1 - NODES), NODES * (2 * NODES - 1)], axis=1
)
SLOPE = np.stack([4 * NODES - 3, 4 - 8 * NODES, 4 * NODES - 1], axis=1)


@njit(cache=True, error_model="numpy")
def _cross(a, out):  # type: ignore[no-untyped-def]
    """[a x] into out (3, 3)."""
    out[0, 0], out[0, 1], out[0, 2] = 0.0, -a[2], a[1]
    out[1, 0], out[1, 1], out[1, 2] = a[2], 0.0, -a[0]
    out[2, 0], out[2, 1], out[2, 2] = -a[1], a[0], 0.0


@njit(cache=True, error_model="numpy")
def _stiffness(t, first, section, K):  # type: ignore[no-untyped-def]
    """K - 1 = sum of (k_i - 1) d_i d_i into K (3, 3), of the directors d_3 = t and d_1 = first."""
    for i in range(3):
        for j in range(3):
            K[i, j] = (section[0] - 1.0) * t[i] * t[j]
    if section[1] != 1.0:
        for i in range(3):
            for j in range(3):
                K[i, j] += (section[1] - 1.0) * first[i] * first[j]
    if section[2] != 1.0:  # d_2 d_2 = 1 - d_1 d_1 - d_3 d_3
        for i in range(3):
            for j in range(3):
                rest = (1.0 if i == j else 0.0) - first[i] * first[j] - t[i] * t[j]
                K[i, j] += (section[2] - 1.0) * rest


@njit(cache=True, error_model="numpy")
def add_rod(F, t, first, n, m, h, section, raised):  # type: ignore[no-untyped-def]
    """Add an element's own form, and sum of raised_i phi_i^2, to the rotations' block.

    t, first (d_1), n, m (STAGES, 3) at its Gauss points.
    """
    G, K = np.empty((3, 3)), np.empty((3, 3))
    for k in range(STAGES):
        _cross(m[k], G)
        _stiffness(t[k], first[k], section, K)
        pull = n[k, 0] * t[k, 0] + n[k, 1] * t[k, 1] + n[k, 2] * t[k, 2]
        for a in range(3):
            for b in range(3):
                bend = WEIGHTS[k] * SLOPE[k, a] * SLOPE[k, b] / h
                load = WEIGHTS[k] * SHAPE[k, a] * SHAPE[k, b] * h
                ab = 0.5 * WEIGHTS[k] * SLOPE[k, a] * SHAPE[k, b]
                ba = 0.5 * WEIGHTS[k] * SHAPE[k, a] * SLOPE[k, b]
                for i in range(3):
                    for j in range(3):
                        value = bend * K[i, j]
                        value -= 0.5 * load * (n[k, i] * t[k, j] + n[k, j] * t[k, i])
                        value -= ab * G[i, j] + ba * G[j, i]
                        if i == j:
                            value += bend + load * (pull + raised[i])
                        F[3 * a + i, 3 * b + j] += value


@njit(cache=True, error_model="numpy")
def move_to_left_end(F, t, h, W):  # type: ignore[no-untyped-def]
    """Write rho at the right end as rho at the left end + W phi; W (3, 9) is filled."""
    W[:] = 0.0
    T = np.empty((3, 3))
    for k in range(STAGES):
        _cross(t[k], T)  # phi x d_3 = -[d_3 x] phi
        for a in range(3):
            for i in range(3):
                for j in range(3):
                    W[i, 3 * a + j] -= h * WEIGHTS[k] * SHAPE[k, a] * T[i, j]
    for j in range(9):
        for i in range(SIZE):
            F[i, j] += F[i, RHO] * W[0, j] + F[i, RHO + 1] * W[1, j] + F[i, RHO + 2] * W[2, j]
    for j in range(9):
        for i in range(SIZE):
            F[j, i] += F[RHO, i] * W[0, j] + F[RHO + 1, i] * W[1, j] + F[RHO + 2, i] * W[2, j]


@njit(cache=True, error_model="numpy")
def add_wall(F, t, w, h, strength, softness, core):  # type: ignore[no-untyped-def]
    """Add int eta.(grad grad v) eta over a wetted element; places w (STAGES, 3) from the centre."""
    grad, H = np.empty(3), np.empty((3, 3))
    eta = np.zeros((3, 15))
    image = np.empty((3, 15))
    T = np.empty((STAGES, 3, 3))
    for k in range(STAGES):
        _cross(t[k], T[k])
    for g in range(STAGES):
        cored_wall(w[g], strength, softness, core, grad, H)
        eta[:] = 0.0
        for k in range(STAGES):
            for a in range(3):
                f = h * MATRIX[g, k] * SHAPE[k, a]
                for i in range(3):
                    for j in range(3):
                        eta[i, 3 * a + j] -= f * T[k, i, j]
        for i in range(3):
            eta[i, RHO + i] = 1.0
            eta[i, CENTRE + i] = -1.0
        for i in range(3):
            for j in range(15):
                image[i, j] = H[i, 0] * eta[0, j] + H[i, 1] * eta[1, j] + H[i, 2] * eta[2, j]
        for i in range(15):
            for j in range(15):
                total = eta[0, i] * image[0, j] + eta[1, i] * image[1, j] + eta[2, i] * image[2, j]
                F[i, j] += h * WEIGHTS[g] * total


@njit(cache=True, error_model="numpy")
def add_meniscus(F, y, cx, cz, section, force, strength, softness):  # type: ignore[no-untyped-def]
    """Add the meniscus in the rotation at RIGHT, rho and rho_C; its slip b is the slide's row.

    y (10,) is the state before the jump, ``force`` f_B.
    """
    t, m, u, bend, turning = np.empty(3), np.empty(3), np.empty(3), np.empty(3), np.empty(3)
    w = y[:3]
    tangent(y[3:7], t)
    moment(cx, cz, w, y[7:10], m)
    bending_strain(m, section, y[3:7], u)
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        bend[i] = u[j] * t[k] - u[k] * t[j]  # d_3'
        turning[i] = t[j] * w[k] - t[k] * w[j]  # w.(phi x d_3) = phi.(d_3 x w)
    across = w[0] * t[0] + w[1] * t[1] + w[2] * t[2]
    curve = w[0] * bend[0] + w[1] * bend[1] + w[2] * bend[2]
    radius = np.sqrt(w[0] * w[0] + w[1] * w[1] + w[2] * w[2])
    push = 2.0 * strength / (softness * softness)  # |grad v| at the meniscus
    slip, turned, pushed = np.zeros(SIZE), np.zeros(SIZE), np.zeros(SIZE)
    moved = np.zeros((3, SIZE))
    for i in range(3):
        moved[i, RHO + i] = 1.0
        moved[i, CENTRE + i] = -1.0
        slip[RHO + i] = -w[i] / across
        slip[CENTRE + i] = w[i] / across
        pushed[RHO + i] = push * w[i] / radius
        pushed[CENTRE + i] = -push * w[i] / radius
        turned[RIGHT + i] = turning[i]
    for i in range(3):
        for j in range(SIZE):
            moved[i, j] += t[i] * slip[j]
    square = 2.0 * force * curve + push * across / radius
    for i in range(SIZE):
        for j in range(SIZE):
            total = (
                moved[0, i] * moved[0, j] + moved[1, i] * moved[1, j] + moved[2, i] * moved[2, j]
            )
            total += slip[i] * turned[j] + turned[i] * slip[j]
            F[i, j] += 2.0 * force * total + square * slip[i] * slip[j]
            F[i, j] += slip[i] * pushed[j] + pushed[i] * slip[j]
    for i in range(SIZE):
        F[SLIDE, i] += slip[i]
        F[i, SLIDE] += slip[i]


@njit(cache=True, error_model="numpy")
def _sweep(nodes, h, inner, p, section, wall, force, raised, D, first, W, N, M, F):  # type: ignore[no-untyped-def]
    """Fill F (SIZE, SIZE) with what is left at the middle; return the negative pivots, -1 if stuck.

    ``wall``: v0, rho and the core's radius.
    """
    count = h.size
    F[:] = 0.0
    for i in range(3):
        F[RHO + i, CLAMP + i] = F[CLAMP + i, RHO + i] = 1.0
        F[CLAMP + i, CLAMP + i] = -CLAMP_COMPLIANCE
    whole, t, gone = np.empty((3, 9)), np.empty(3), np.empty(SIZE)
    negative = 0
    for e in range(count - 1, -1, -1):
        wet = e < inner
        add_rod(F, D[e], first[e], N[e], M[e], h[e], section, raised)
        move_to_left_end(F, D[e], h[e], whole)
        if wet:
            add_wall(F, D[e], W[e], h[e], wall[0], wall[1], wall[2])
        tangent(nodes[e if wet else e + 1, 3:7], t)
        for at in range(2):  # the turn e_z - d_3 of the left and of the middle rotation
            d = t if at == 0 else D[e, STAGES // 2]
            for i in range(3):
                value = (1.0 if i == 2 else 0.0) - d[i]
                F[3 * at + i, TURN] += value
                F[TURN, 3 * at + i] += value
                F[TURN, TURN] -= value * value / TURN_PENALTY
        if e == count - 1:  # the clamp holds its rotation
            for i in range(RIGHT, RIGHT + 3):
                F[i, :] = 0.0
                F[:, i] = 0.0
                F[i, i] = 1.0
        more = eliminate(F, 3, 9, gone)
        if more < 0:
            return -1
        negative += more
        for i in range(3):
            for j in range(SIZE):
                F[RIGHT + i, j], F[i, j] = F[i, j], 0.0
        for i in range(3):
            for j in range(SIZE):
                F[j, RIGHT + i], F[j, i] = F[j, i], 0.0
        if e == inner:
            add_meniscus(F, nodes[inner], p[0], p[1], section, force, wall[0], wall[1])
    y = nodes[-1, 1]  # r_C = (0, -w_y(l/2), 0): turning about the clamp axis moves it
    F[CENTRE, TURN] += y
    F[TURN, CENTRE] += y
    F[TURN, TURN] -= (y * y + 1e-12) / TURN_PENALTY
    return negative


def core_radius(state: HalfRod) -> float:
    """The wall's core that the second variation of a state has: CORE where the rod runs through the
    drop's centre, as all point-symmetric curves do, and none (0) elsewhere (D)."""
    return 0.0 if state.nodes[0, :3].any() else CORE


def condensed(
    state: HalfRod, raised: float | np.ndarray = 0.0, core: float | None = None
) -> tuple[int, np.ndarray]:
    """The negative pivots met from the clamp to the middle, and what is left there.

    ``raised`` (K/D^2), a number or one each for x, y and z, is added to the form as sum of raised_i
    phi_i^2. ``core`` (D): of the wall, ``core_radius`` by default.

    The matrix (14, 14) is in phi(0), rho(0), rho_C, the multipliers of rho(clamp) = 0 (3), the turn
    and the slide (slip b = 0 of the meniscus), of the form of half a rod, in K0. Raises
    ArithmeticError where the elimination meets no pivot.
    """
    prm = state.parameters
    fields = evaluate_fields(state)
    after, jacobian = np.empty(10), np.empty((10, 11))
    force = jump(
        state.nodes[state.inner], float(state.scalars[5]), prm.meniscus_wall, after, jacobian
    )
    front = np.empty((SIZE, SIZE))
    core = core_radius(state) if core is None else core
    wall = np.array([prm.wall_strength, prm.wall_softness, core])
    negative = _sweep(
        state.nodes,
        state.lengths,
        state.inner,
        state.scalars[:4],
        prm.section,
        wall,
        force,
        np.broadcast_to(np.asarray(raised, dtype=float), 3).copy(),
        fields.tangents,
        section_fields(state, fields)[1],
        fields.places,
        fields.forces,
        fields.moments,
        front,
    )
    if negative < 0:
        raise ArithmeticError("the second variation has an element without a pivot")
    return int(negative), front[RIGHT:, RIGHT:]
