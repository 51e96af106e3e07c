"""Fictitious masses of explicit relaxation, such that a time step of 1 is stable on every mesh.

The coordinates are the free nodes, the wetted length and the drop's centre. Growing the wetted length by
2 moves the menisci by -1 and +1 and carries every node along the tangent with its arc length: with the
nodes held in place every edge would be strained, and the length would be an extremely heavy coordinate.

Leapfrog with the step 1 is stable where M - H/4 > 0, H being the Hessian of the augmented Lagrangian

    E_tot + sum_e (lambda_e g_e + kappa_e g_e^2 / 2) + (the same for the menisci's places)

Gershgorin's circles give such an M from sums of |H|. A node has its own mass along the rod and across:
the constraints are charged to their directions by (sum g_i.x_i)^2 <= (sum |g_i|) sum (g_i.x_i)^2 / |g_i|.
So kappa can be large, and tension travel fast, without making the rod heavy to bend.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from derod.algebra.bordered import subtract_product
from derod.algebra.jit import allocating_kernel
from derod.rod.assembly import hessian
from derod.rod.unknowns import F_A, MOMENT, S_A, S_B, X_C

STIFFNESS = 16.0  # of an edge of length h against stretch, times h^3: that of bending
SAFETY = (
    1.4  # masses over what Gershgorin's circles ask for: the state moves on before they are renewed
)


class Inertia(NamedTuple):
    """Penalties, masses, and the motion that the wetted length carries."""

    penalty: np.ndarray  # (N+2,) kappa of the edges
    menisci: np.ndarray  # (1,) kappa of the menisci's places
    carried: np.ndarray  # (N+1, d) dx/d(wetted length / 2)
    inverse: np.ndarray  # (N+1, d, d) inverse masses of the nodes
    wetted: np.ndarray  # (1,) mass of half the wetted length
    centre: np.ndarray  # (d,) masses of x_C


def new_inertia(edges: int, d: int) -> Inertia:
    """Return room for the masses."""
    return Inertia(
        np.zeros(edges + 2),
        np.zeros(1),
        np.zeros((edges + 1, d)),
        np.zeros((edges + 1, d, d)),
        np.ones(1),
        np.ones(d),
    )


@allocating_kernel
def fill_penalties(kin, inertia):
    """Fill kappa_e = 16 / (l_min l_e^2).

    With l_e^3 a long edge would be a soft spring between the heavy nodes beside the menisci, and
    those slow to move; with l_min^3 a long edge could hardly turn before its mass is out of date.
    """
    shortest = kin.rest[1]
    for e in range(2, kin.rest.size - 1):
        shortest = min(shortest, kin.rest[e])
    for e in range(1, kin.rest.size - 1):
        inertia.penalty[e] = STIFFNESS / (shortest * kin.rest[e] * kin.rest[e])
    inertia.menisci[0] = inertia.penalty[kin.node_a]


@allocating_kernel
def fill_carried(kin, carried):
    """Fill dx/d(wetted length / 2): every node slides along the tangent with its arc length."""
    place = 0.0
    for i in range(1, carried.shape[0] - 1):
        place += kin.slope[1, i] - kin.slope[0, i]
        for k in range(carried.shape[1]):
            carried[i, k] = 0.5 * place * (kin.tangent[k, i] + kin.tangent[k, i + 1])


@allocating_kernel
def fill_masses(physics, q, b, psi, room, factor, inertia):
    """Fill ``inertia`` at the state whose ``gradient`` was taken last; ``factor`` lends its room."""
    d = len(physics.axis)
    n = q.shape[0] - 1
    hessian(physics, q, b, psi, room)
    fill_penalties(room.kin, inertia)
    fill_carried(room.kin, inertia.carried)
    grown, grown_border = carried_product(physics, room.linear, factor, inertia)
    fill_border_masses(physics, room.kin, room.linear, grown, grown_border, inertia)
    add_row_sums(physics, room.linear, grown, inertia.inverse)
    add_constraints(physics, room.kin, room.linear, inertia)
    for i in range(1, n):
        inertia.inverse[i] = np.linalg.inv(0.25 * SAFETY * inertia.inverse[i])
    inertia.wetted[0] *= 0.25 * SAFETY
    for k in range(d):
        inertia.centre[k] *= 0.25 * SAFETY


@allocating_kernel
def carried_product(physics, linear, factor, inertia):
    """Return the Hessian of the augmented Lagrangian times the carried motion: (band rows, border)."""
    carried, penalty = inertia.carried, inertia.penalty
    d = carried.shape[1]
    n = carried.shape[0] - 1
    x, y = factor.rhs, factor.rhs_border
    out, out_border = factor.right, factor.right_border
    x[:] = 0.0
    y[:] = 0.0
    out[:] = 0.0
    out_border[:] = 0.0
    for i in range(1, n):
        for k in range(d):
            x[(d + 1) * (i - 1) + k] = -carried[i, k]
    y[S_A], y[S_B] = 1.0, -1.0
    subtract_product(linear, x, y, out, out_border)
    # the constraints' share, grad g kappa (grad g . motion), by a second product
    x[:] = 0.0
    y[:] = 0.0
    for e in range(1, n + 1):
        x[(d + 1) * (e - 1) + d] = -penalty[e] * out[(d + 1) * (e - 1) + d]
    for side in range(2):
        y[F_A + d + side] = -inertia.menisci[0] * out_border[F_A + d + side]
    if d == 3:
        y[MOMENT + d] = -physics.twisting / physics.length * out_border[MOMENT + d]
    subtract_product(linear, x, y, out, out_border)
    return out, out_border


@allocating_kernel
def fill_border_masses(physics, kin, linear, grown, grown_border, inertia):
    """Fill the row sums of the wetted length and of x_C."""
    border, corner = linear.border, linear.corner
    n, d = inertia.carried.shape[0] - 1, inertia.carried.shape[1]
    own = grown_border[S_B] - grown_border[S_A]
    wetted = 0.0
    inertia.centre[:] = 0.0
    for i in range(1, n):
        for k in range(d):
            j = (d + 1) * (i - 1) + k
            own += inertia.carried[i, k] * grown[j]
            wetted += abs(grown[j])
            for m in range(d):
                inertia.centre[m] += abs(border[j, X_C + m])
    for k in range(d):
        wetted += abs(grown_border[X_C + k])
        inertia.centre[k] += abs(grown_border[X_C + k])
        for m in range(d):
            inertia.centre[k] += abs(corner[X_C + k, X_C + m])
        for side in range(2 if physics.drop else 0):
            i = kin.node_a if side == 0 else kin.node_b
            slope = border[(d + 1) * (i - 1) + k, F_A + d + side]
            inertia.centre[k] += 2 * inertia.menisci[0] * abs(slope)
    inertia.wetted[0] = wetted + abs(own)


@allocating_kernel
def add_row_sums(physics, linear, grown, blocks):
    """Set the nodes' blocks to the row sums of the Lagrangian's Hessian, alike in all directions."""
    band, border = linear.band, linear.border
    n, d = blocks.shape[0] - 1, blocks.shape[1]
    twisting = 0.0
    if d == 3:  # k3/l grad psi grad psi
        twisting = np.sum(np.abs(border[:, MOMENT + d])) * physics.twisting / physics.length
    blocks[:] = 0.0
    for i in range(1, n):
        largest = 0.0
        for k in range(d):
            j = (d + 1) * (i - 1) + k
            total = abs(grown[j])
            if d == 3:
                total += twisting * abs(border[j, MOMENT + d])
            for m in range(d):
                total += abs(border[j, X_C + m])
            for o in range(max(1, i - 3), min(n - 1, i + 3) + 1):
                for m in range(d):
                    c = (d + 1) * (o - 1) + m
                    total += abs(band[min(j, c), abs(j - c)])
            largest = max(largest, total)
        for k in range(d):
            blocks[i, k, k] = largest


@allocating_kernel
def add_constraints(physics, kin, linear, inertia):
    """Add the penalties kappa to the nodes' blocks, along the constraints' directions."""
    band, border, blocks = linear.band, linear.border, inertia.inverse
    n, d = blocks.shape[0] - 1, blocks.shape[1]
    slopes = np.zeros((4, d))
    sizes = np.zeros(4)
    for e in range(1, n + 1):
        row = (d + 1) * (e - 1) + d
        first, last = max(1, e - 2), min(n - 1, e + 1)
        for o in range(first, last + 1):
            square = 0.0
            for m in range(d):
                c = (d + 1) * (o - 1) + m
                slopes[o - first, m] = band[min(row, c), abs(row - c)]
                square += slopes[o - first, m] ** 2
            sizes[o - first] = math.sqrt(square)
        total = inertia.penalty[e] * np.sum(sizes[: last - first + 1])
        for o in range(first, last + 1):
            add_direction(blocks[o], slopes[o - first], total / (sizes[o - first] + 1e-300))
    for side in range(2 if physics.drop else 0):
        i = kin.node_a if side == 0 else kin.node_b
        for k in range(d):
            slopes[0, k] = border[(d + 1) * (i - 1) + k, F_A + d + side]
        add_direction(blocks[i], slopes[0], 2 * inertia.menisci[0])


@allocating_kernel
def add_direction(block, g, weight):
    """Add weight g g^T to a block."""
    for k in range(g.size):
        for m in range(g.size):
            block[k, m] += weight * g[k] * g[m]
