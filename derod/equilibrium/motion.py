"""What accelerated steps remember, and when the metric they are taken in has to be renewed."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from derod.algebra.bordered import factorize, subtract_product
from derod.algebra.copying import copy_vector
from derod.algebra.jit import inlined
from derod.equilibrium.elliptic_mass import fill_operator
from derod.rod.residual import EPS, ROUNDING, WALL_ROUNDING
from derod.rod.unknowns import BORDER, F_A

LARGEST_STEP = 0.8  # h_0: the largest eigenvalues of M^{-1} H are 1.1 to 1.4
MOST_TURNED = 0.15  # rad of an edge before M and A are renewed
MOST_BARRIER = 1.5  # growth of a node's barrier before M is renewed
MOST_AGE = 100  # steps
SHARE = 0.1  # of the tolerance on forces, that on their norm in M^{-1}
AGE, SINCE, STEP, RESTORED, LEFT = 0, 1, 2, 3, 4  # places in ``Motion.memory``


class Motion(NamedTuple):
    """Velocities, and what is remembered between two calls."""

    velocity: np.ndarray  # (N+1, d+1) of the nodes; beside them A v of the edge that ends there
    border: (
        np.ndarray
    )  # (d+5,) of s_A, s_B, x_C; then A v of the menisci's and the slide's constraints
    old_q: np.ndarray  # (N+1, d+1) the state before a step
    old_b: np.ndarray  # (d+5,)
    barrier: np.ndarray  # (N+1,) the wall's stiffness when M was filled
    memory: np.ndarray  # (5,) steps since M was filled (-1: never), steps since rest, h,
    #                     steps that brought back lengths, |F| in M^{-1} over its tolerance


def new_motion(edges: int, d: int) -> Motion:
    """Return a state of rest."""
    return Motion(
        np.zeros((edges + 1, d + 1)),
        np.zeros(BORDER + d),
        np.zeros((edges + 1, d + 1)),
        np.zeros(BORDER + d),
        np.zeros(edges + 1),
        np.array([-1.0, 0.0, LARGEST_STEP, 0.0, np.inf]),
    )


@inlined
def shape(kin, r):
    """Return (largest strain of an edge, largest 1 - cos phi)."""
    strain, sharpest = 0.0, 0.0
    for e in range(1, r.shape[0]):
        strain = max(strain, abs(r[e, r.shape[1] - 1]) / kin.rest[e])
    for i in range(kin.fall.size):
        sharpest = max(sharpest, kin.fall[i])
    return strain, sharpest


@inlined
def is_stale(kin, hess, motion):
    """Return whether the state has left the one M and A were filled at."""
    if motion.memory[AGE] < 0 or motion.memory[AGE] >= MOST_AGE:
        return True
    stale = False
    for e in range(1, kin.rest.size - 1):
        square = 0.0
        for k in range(kin.tangent.shape[0]):
            square += (kin.tangent[k, e] - hess.tangent[e, k]) ** 2
        stale |= square > MOST_TURNED * MOST_TURNED
    for i in range(kin.node_a, kin.node_b + 1):
        stale |= kin.barrier[i] > MOST_BARRIER * motion.barrier[i]
    return stale


@inlined
def renew(physics, q, b, room, factor, motion):
    """Fill and factor M and A at the state; take A v anew."""
    fill_operator(physics, q, b, room, factor)
    factorize(room.linear, factor)
    copy_vector(room.kin.barrier, motion.barrier)
    motion.memory[AGE] = 0
    d, n = motion.velocity.shape[1] - 1, motion.velocity.shape[0] - 1
    x, y, out, out_border = factor.rhs, factor.rhs_border, factor.right, factor.right_border
    x[:] = 0.0
    y[:] = 0.0
    out[:] = 0.0
    out_border[:] = 0.0
    for i in range(1, n):
        for k in range(d):
            x[(d + 1) * (i - 1) + k] = motion.velocity[i, k]
    for k in range(F_A + d):
        y[k] = motion.border[k]
    subtract_product(room.linear, x, y, out, out_border)
    for e in range(1, n + 1):
        motion.velocity[e, d] = -out[(d + 1) * (e - 1) + d]
    for k in range(F_A + d, BORDER + d):
        motion.border[k] = -out_border[k]


@inlined
def power(r, rb, motion):
    """Return F.v."""
    d, n = motion.velocity.shape[1] - 1, motion.velocity.shape[0] - 1
    total = 0.0
    for i in range(1, n):
        for k in range(d):
            total -= r[i, k] * motion.velocity[i, k]
    for k in range(F_A + d):
        total -= rb[k] * motion.border[k]
    return total


@inlined
def left(physics, kin, square, tolerance):
    """Return |F| in M^{-1}, the root of ``square``, over what is allowed and what rounding leaves.

    It bounds the energy that is still to be lost, whatever the mesh; the largest force on a node says
    little about soft modes. Positions are known to eps l / 4 on average, forces to that times a node's
    mass m, which leaves eps l sqrt(m) / 4 of the norm.
    """
    mass = 0.0
    for i in range(1, kin.rest.size - 2):
        h = min(kin.rest[i], kin.rest[i + 1])
        mass += ROUNDING / (h * h * h) + WALL_ROUNDING * kin.barrier[i]
    rounding = 0.25 * EPS * physics.length
    return math.sqrt(abs(square) / ((SHARE * tolerance) ** 2 + rounding * rounding * mass))
