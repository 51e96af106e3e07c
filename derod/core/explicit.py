"""Explicit dynamic relaxation: fictitious masses, no time step and no damping constant to choose.

Inextensibility and the menisci's places are held by an augmented Lagrangian,

    mu = lambda + kappa g,   kappa = 16/l^3 of the shortest edge

whose multipliers are renewed whenever the forces have fallen by a factor, so that no strain is left in
the answer. The masses are block row sums of its Hessian: with them the stable time step is 1 for every
mesh. A node has its own mass along the rod and across, so that kappa, alike everywhere, lets tension
travel fast without making the rod heavy to bend.
Damping is FIRE's (Bitzek et al. 2006) or kinetic (restart at each peak of the kinetic energy).
"""

from __future__ import annotations

import math

import numpy as np

from derod.core.assembly import constraints, forces, hessian
from derod.core.jit import kernel
from derod.core.layout import S_A, S_B, X_C
from derod.core.residual import excess
from derod.core.wall import squared_distance, wall_gap
from derod.linalg.bordered import subtract_product

STIFFNESS = 16.0  # of a stretched edge, over the shortest length cubed
SAFETY = 1.3  # masses over what Gershgorin's circles ask for
GAP_SHARE = 0.125  # of the least wall gap that a node may move in one step
RENEW = 0.3  # forces fall by this between two renewals of the multipliers
FIRE_GROW, FIRE_CUT, FIRE_MIX, FIRE_FADE, FIRE_WAIT = 1.1, 0.5, 0.25, 0.99, 5
STEP, MIX, SINCE, KINETIC, LEVEL = 0, 1, 2, 3, 4  # places in the memory
MEMORY = 5


@kernel
def stiffness(kin):
    """Return kappa, the penalty of all constraints."""
    shortest = kin.rest[1]
    for e in range(2, kin.rest.size - 1):
        shortest = min(shortest, kin.rest[e])
    return STIFFNESS / (shortest * shortest * shortest)


@kernel
def carry(kin, d, field):
    """Fill ``field`` (N+1, d): where the nodes go as the wetted length grows by 2, the curve held fast.

    The menisci move by -1 and +1, and every node slides along the tangent with its arc length.
    """
    place = 0.0
    for i in range(1, field.shape[0] - 1):
        place += kin.slope[1, i] - kin.slope[0, i]
        for k in range(d):
            field[i, k] = 0.5 * place * (kin.tangent[i, k] + kin.tangent[i + 1, k])


@kernel
def masses(physics, q, b, psi, end_rotation, room, factor, kappa, field, inverse, mb):
    """Fill the inverse masses of the nodes (N+1, d, d), and those of the wetted length and x_C.

    A node's mass is the block row sum of the augmented Lagrangian's Hessian, times SAFETY/4, so that
    the step 1 is stable: isotropic from the rod and the wall, directed from the constraints, of which
    (sum g_i . x_i)^2 <= (sum |g_i|) sum (g_i . x_i)^2 / |g_i|. The wetted length grows with the nodes
    carried along (``carry``): its row is the product of the Hessian with that motion, and its mass
    mb[0]. ``gradient`` was taken at the state.
    """
    d = len(physics.axis)
    n = q.shape[0] - 1
    kin, linear = room.kin, room.linear
    hessian(physics, q, b, psi, end_rotation, room)
    carry(kin, d, field)
    grown, grown_border = carried_product(physics, linear, factor, kappa, field)
    band, border, corner = linear.band, linear.border, linear.corner
    inverse[:] = 0.0
    mb[:] = 0.0
    for i in range(1, n):
        largest = 0.0
        for k in range(d):
            j = (d + 1) * (i - 1) + k
            total = abs(grown[j])
            mb[0] += total
            for o in range(max(1, i - 2), min(n - 1, i + 2) + 1):
                for m in range(d):
                    c = (d + 1) * (o - 1) + m
                    total += abs(band[min(j, c), abs(j - c)])
            for m in range(d):
                total += abs(border[j, X_C + m])
                mb[X_C + m] += abs(border[j, X_C + m])
            largest = max(largest, total)
        for k in range(d):
            inverse[i, k, k] += largest
    for k in range(d):
        mb[0] += abs(grown_border[X_C + k])
        mb[X_C + k] += abs(grown_border[X_C + k])
        for m in range(d):
            mb[X_C + k] += abs(corner[X_C + k, X_C + m])
    own = grown_border[S_B] - grown_border[S_A]
    for i in range(1, n):
        for k in range(d):
            own += field[i, k] * grown[(d + 1) * (i - 1) + k]
    mb[0] += abs(own)
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
        total = np.sum(sizes[: last - first + 1])
        for o in range(first, last + 1):
            add_direction(inverse[o], slopes[o - first], kappa * total / (sizes[o - first] + 1e-300))
    for side in range(2):
        i = kin.node_a if side == 0 else kin.node_b
        for k in range(d):
            slopes[0, k] = border[(d + 1) * (i - 1) + k, X_C + d + side]
            mb[X_C + k] += 2 * kappa * abs(slopes[0, k])
        add_direction(inverse[i], slopes[0], 2 * kappa)
    if d == 3:  # twist: k3/l grad psi grad psi
        total = np.sum(np.abs(border[:, d + 5])) * physics.twisting / physics.length
        for i in range(1, n):
            for k in range(d):
                inverse[i, k, k] += total * abs(border[(d + 1) * (i - 1) + k, d + 5])
    for i in range(1, n):
        inverse[i] = np.linalg.inv(0.25 * SAFETY * inverse[i])
    mb *= 0.25 * SAFETY


@kernel
def add_direction(block, g, weight):
    """Add weight g g^T to a block."""
    for k in range(g.size):
        for m in range(g.size):
            block[k, m] += weight * g[k] * g[m]


@kernel
def carried_product(physics, linear, factor, kappa, field):
    """Return the augmented Lagrangian's Hessian times the motion of ``carry``: (band rows, border)."""
    d = field.shape[1]
    n = field.shape[0] - 1
    x, y = factor.rhs, factor.rhs_border
    out, out_border = factor.right, factor.right_border
    x[:] = 0.0
    y[:] = 0.0
    out[:] = 0.0
    out_border[:] = 0.0
    for i in range(1, n):
        for k in range(d):
            x[(d + 1) * (i - 1) + k] = -field[i, k]
    y[S_A], y[S_B] = 1.0, -1.0
    subtract_product(linear, x, y, out, out_border)
    # the constraints' share, grad g kappa (grad g . motion), by a second product
    x[:] = 0.0
    y[:] = 0.0
    for e in range(1, n + 1):
        x[(d + 1) * (e - 1) + d] = -kappa * out[(d + 1) * (e - 1) + d]
    for side in range(2):
        y[X_C + d + side] = -kappa * out_border[X_C + d + side]
    if d == 3:
        y[d + 5] = -physics.twisting / physics.length * out_border[d + 5]
    subtract_product(linear, x, y, out, out_border)
    return out, out_border


@kernel
def augment(physics, room, kappa, base, base_f, q, b):
    """Set the multipliers in q and b to mu = lambda + kappa g; after ``constraints``."""
    d = len(physics.axis)
    for e in range(1, q.shape[0]):
        q[e, d] = base[e] + kappa * room.grad.constraint[e]
    for side in range(2):
        i = room.kin.node_a if side == 0 else room.kin.node_b
        b[X_C + d + side] = base_f[side] + kappa * (squared_distance(physics, q, b, i) - 0.25)


@kernel
def damp(kinetic, power, speed2, force2, memory):
    """Return (dt, factor on the velocity, factor on force/mass) of this step; update the memory.

    ``power`` is F.v; ``speed2`` = v.m v and ``force2`` = F.F/m are the squared norms FIRE mixes.
    """
    if kinetic:
        if speed2 < memory[KINETIC]:
            memory[KINETIC] = 0.0
            return 1.0, 0.0, 0.5
        memory[KINETIC] = speed2
        return 1.0, 1.0, 1.0
    if power <= 0:
        memory[STEP] = max(FIRE_CUT * memory[STEP], 0.02)
        memory[MIX] = FIRE_MIX
        memory[SINCE] = 0
        return memory[STEP], 0.0, 0.5 * memory[STEP]
    memory[SINCE] += 1
    mix = memory[MIX]
    if memory[SINCE] > FIRE_WAIT:
        memory[STEP] = min(FIRE_GROW * memory[STEP], 1.0)
        memory[MIX] *= FIRE_FADE
    slowness = math.sqrt(speed2 / (force2 + 1e-300))
    mix = min(mix, 0.25 * memory[STEP] / (slowness + 1e-300))
    return memory[STEP], 1 - mix, memory[STEP] + mix * slowness


@kernel
def explicit_steps(
    physics, mesh, end_rotation, tolerance, kinetic, steps, psi, room, q, b, kappa, base, base_f, field,
    vq, pq, pull, vb, inverse, mb, memory
):
    """Move the state (q, b, psi) in place by up to ``steps`` damped steps.

    ``base``, ``base_f`` hold lambda, ``vq``, ``vb`` the velocities, ``pq`` the momenta, ``memory`` the
    damping's state; all go on from call to call. On return the gradient in ``room`` is that of the state.
    Returns (steps done, psi, excess, force residual, sound).
    """
    d = len(physics.axis)
    n = q.shape[0] - 1
    sound = constraints(physics, mesh, q, b, room)
    augment(physics, room, kappa, base, base_f, q, b)
    psi, finite = forces(physics, q, b, psi, end_rotation, room)
    sound &= finite
    gap = wall_gap(physics, room.kin, q, b)
    done = 0
    worst, force = excess(physics, room.r, room.rb, room.kin, tolerance)
    while done < steps and sound and gap > 0:
        r, rb = room.r, room.rb
        b[X_C + d + 2] -= 0.5 * (rb[S_A] + rb[S_B])  # the pinned sliding
        growth = rb[S_B] - rb[S_A]
        power, speed2, force2 = 0.0, mb[0] * vb[0] * vb[0], 0.0
        for i in range(1, n):
            for k in range(d):
                f = -r[i, k]
                growth -= f * field[i, k]
                power += f * vq[i, k]
                speed2 += pq[i, k] * vq[i, k]
                a = 0.0
                for m in range(d):
                    a -= inverse[i, k, m] * r[i, m]
                pull[i, k] = a
                force2 += f * a
        power -= growth * vb[0]
        force2 += growth * growth / mb[0]
        for k in range(X_C, X_C + d):
            power -= rb[k] * vb[k]
            speed2 += mb[k] * vb[k] * vb[k]
            force2 += rb[k] * rb[k] / mb[k]
        dt, keep, push = damp(kinetic, power, speed2, force2, memory)
        vb[0] = keep * vb[0] - push * growth / mb[0]
        fastest = abs(vb[0])
        for k in range(X_C, X_C + d):
            vb[k] = keep * vb[k] - push * rb[k] / mb[k]
            fastest = max(fastest, abs(vb[k]))
        for i in range(1, n):
            for k in range(d):
                pq[i, k] = keep * pq[i, k] - push * r[i, k]
                v = keep * vq[i, k] + push * pull[i, k]
                vq[i, k] = v
                fastest = max(fastest, abs(v))
        dt = min(dt, GAP_SHARE * gap / (fastest + 1e-300))
        for i in range(1, n):
            for k in range(d):
                q[i, k] += dt * (vq[i, k] + field[i, k] * vb[0])
        b[S_A] -= dt * vb[0]
        b[S_B] += dt * vb[0]
        for k in range(X_C, X_C + d):
            b[k] += dt * vb[k]
        sound = constraints(physics, mesh, q, b, room)
        augment(physics, room, kappa, base, base_f, q, b)
        psi, finite = forces(physics, q, b, psi, end_rotation, room)
        sound &= finite
        gap = wall_gap(physics, room.kin, q, b)
        done += 1
        if done % 10 == 0 or done == steps:
            worst, force = excess(physics, room.r, room.rb, room.kin, tolerance)
            if worst <= 1:
                break
            if force <= max(memory[LEVEL], 0.5 * tolerance):  # settled for these multipliers
                base[1:] = q[1:, d]
                base_f[0], base_f[1] = b[X_C + d], b[X_C + d + 1]
                memory[LEVEL] = RENEW * force
    return done, psi, worst, force, sound and gap > 0
