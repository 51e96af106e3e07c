"""Explicit dynamic relaxation: fictitious masses, no time step and no damping constant to choose.

Inextensibility and the menisci's places are held by an augmented Lagrangian,

    mu = lambda + kappa g,   kappa = 16/l^3 (no stiffer than bending on that edge)

whose multipliers are renewed whenever the forces have fallen by a factor, so that no strain is left in
the answer. The masses are row sums of its Hessian: with them the stable time step is 1 for every mesh.
Damping is FIRE's (Bitzek et al. 2006) or kinetic (restart at each peak of the kinetic energy).
"""

from __future__ import annotations

import math

import numpy as np

from derod.core.assembly import gradient, hessian
from derod.core.jit import kernel
from derod.core.layout import S_A, S_B, X_C
from derod.core.residual import excess
from derod.core.wall import wall_gap

STIFFNESS = 16.0  # of a stretched edge, over its length cubed
SAFETY = 1.3  # masses over what Gershgorin's circles ask for
GAP_SHARE = 0.125  # of the least wall gap that a node may move in one step
RENEW = 0.3  # forces fall by this between two renewals of the multipliers
FIRE_GROW, FIRE_CUT, FIRE_MIX, FIRE_FADE, FIRE_WAIT = 1.1, 0.5, 0.25, 0.99, 5
STEP, MIX, SINCE, KINETIC, LEVEL = 0, 1, 2, 3, 4  # places in the memory
MEMORY = 5


@kernel
def edge_stiffness(rest):
    """Return kappa of an edge."""
    return STIFFNESS / (rest * rest * rest)


@kernel
def masses(physics, q, b, psi, end_rotation, room, mq, mb):
    """Fill the masses of the nodes (N+1,) and of s_A, s_B, x_C; ``gradient`` was taken at the state.

    Row sums of |K + sum kappa grad g grad g^T|, times SAFETY/4, so that the step 1 is stable.
    """
    d = len(physics.axis)
    n = q.shape[0] - 1
    kin, linear = room.kin, room.linear
    hessian(physics, q, b, psi, end_rotation, room)
    band, border, corner = linear.band, linear.border, linear.corner
    rows = (d + 1) * n
    sums = np.zeros(rows)
    heads = np.zeros(d + 5)
    for j in range(rows):  # K itself, without the multipliers' rows
        if j % (d + 1) == d:
            continue
        sums[j] += abs(band[j, 0])
        for k in range(1, band.shape[1]):
            if (j + k) % (d + 1) != d and j + k < rows:
                sums[j] += abs(band[j, k])
                sums[j + k] += abs(band[j, k])
        for k in range(X_C + d):
            sums[j] += abs(border[j, k])
            heads[k] += abs(border[j, k])
    for k in range(X_C + d):
        for i in range(X_C + d):
            heads[k] += abs(corner[k, i])
    for e in range(1, n + 1):  # kappa grad g grad g^T of every edge
        row = (d + 1) * (e - 1) + d
        total = abs(border[row, S_A]) + abs(border[row, S_B])
        first, last = (d + 1) * max(e - 3, 0), min((d + 1) * (e + 1), rows)
        for j in range(first, last):
            if j % (d + 1) != d:
                total += abs(band[min(row, j), abs(row - j)]) if abs(row - j) < band.shape[1] else 0.0
        kappa = edge_stiffness(kin.rest[e])
        for j in range(first, last):
            if j % (d + 1) != d and abs(row - j) < band.shape[1]:
                sums[j] += kappa * total * abs(band[min(row, j), abs(row - j)])
        heads[S_A] += kappa * total * abs(border[row, S_A])
        heads[S_B] += kappa * total * abs(border[row, S_B])
    for side in range(2):  # and of the two menisci
        i = kin.node_a if side == 0 else kin.node_b
        kappa = meniscus_stiffness(kin, i)
        column = X_C + d + side
        total = 0.0
        for k in range(d):
            total += 2 * abs(border[(d + 1) * (i - 1) + k, column])
        for k in range(d):
            g = abs(border[(d + 1) * (i - 1) + k, column])
            sums[(d + 1) * (i - 1) + k] += kappa * total * g
            heads[X_C + k] += kappa * total * g
    if d == 3:  # twist: k3/l grad psi grad psi
        total = 0.0
        for j in range(rows):
            total += abs(border[j, d + 5])
        for j in range(rows):
            sums[j] += physics.twisting / physics.length * total * abs(border[j, d + 5])
    for i in range(1, n):
        largest = 0.0
        for k in range(d):
            largest = max(largest, sums[(d + 1) * (i - 1) + k])
        mq[i] = 0.25 * SAFETY * largest
    for k in range(X_C + d):
        mb[k] = 0.25 * SAFETY * heads[k]
    mb[S_A] = mb[S_B] = 2 * max(mb[S_A], mb[S_B])  # they move as one, mirrored


@kernel
def meniscus_stiffness(kin, i):
    """Return kappa of a meniscus' place on the sphere."""
    h = 0.5 * (kin.rest[i] + kin.rest[i + 1])
    return STIFFNESS / (h * h * h)


@kernel
def augment(physics, room, base, base_f, q, b):
    """Set the multipliers in q and b to mu = lambda + kappa g, with the g of the gradient last taken.

    An edge's own length enters up to date; its arc's share, which hardly moves, with one step's delay.
    """
    d = len(physics.axis)
    kin = room.kin
    for e in range(1, q.shape[0]):
        g = room.grad.constraint[e]
        square = 0.0
        for k in range(d):
            square += (q[e, k] - q[e - 1, k]) ** 2
        g += 0.5 * (square - kin.size[e] * kin.size[e]) / kin.rest[e]
        q[e, d] = base[e] + edge_stiffness(kin.rest[e]) * g
    for side in range(2):
        i = kin.node_a if side == 0 else kin.node_b
        square = 0.0
        for k in range(d):
            square += (q[i, k] - b[X_C + k]) ** 2
        b[X_C + d + side] = base_f[side] + meniscus_stiffness(kin, i) * (square - 0.25)


@kernel
def damp(kinetic, power, speed2, force2, memory):
    """Return (dt, factor on the velocity, factor on force/mass) of this step; update the memory.

    ``power`` is F.v; ``speed2`` = v.m v and ``force2`` = F.F/m are the squared norms FIRE mixes.
    """
    if kinetic:
        if speed2 < memory[KINETIC]:
            memory[KINETIC] = 0.0
            return 1.0, 0.0, 1.0
        memory[KINETIC] = speed2
        return 1.0, 1.0, 1.0
    if power <= 0:
        memory[STEP] = max(FIRE_CUT * memory[STEP], 0.02)
        memory[MIX] = FIRE_MIX
        memory[SINCE] = 0
        return memory[STEP], 0.0, memory[STEP]
    memory[SINCE] += 1
    mix = memory[MIX]
    if memory[SINCE] > FIRE_WAIT:
        memory[STEP] = min(FIRE_GROW * memory[STEP], 1.0)
        memory[MIX] *= FIRE_FADE
    steer = mix * math.sqrt(speed2 / (force2 + 1e-300))
    return memory[STEP], 1 - mix, memory[STEP] + steer


@kernel
def explicit_steps(
    physics, mesh, end_rotation, tolerance, kinetic, steps, psi, room, q, b, base, base_f, vq, vb, mq, mb, memory
):
    """Move the state (q, b, psi) in place by up to ``steps`` damped steps.

    ``base``, ``base_f`` hold lambda, ``vq``, ``vb`` the velocities, ``memory`` the damping's state; all
    go on from call to call. On return the gradient in ``room`` is that of the state.
    Returns (steps done, psi, excess, force residual, sound).
    """
    d = len(physics.axis)
    n = q.shape[0] - 1
    psi, sound = gradient(physics, mesh, q, b, psi, end_rotation, room)
    gap = wall_gap(physics, room.kin, q, b)
    done = 0
    worst, force = excess(physics, room.r, room.rb, room.kin, tolerance)
    while done < steps and sound and gap > 0:
        slide = 0.5 * (room.rb[S_B] - room.rb[S_A])
        b[X_C + d + 2] -= 0.5 * (room.rb[S_A] + room.rb[S_B])
        room.rb[S_A], room.rb[S_B] = -slide, slide
        power, speed2, force2 = 0.0, 0.0, 0.0
        for i in range(1, n):
            inverse = 1.0 / mq[i]
            for k in range(d):
                f, v = -room.r[i, k], vq[i, k]
                power += f * v
                speed2 += mq[i] * v * v
                force2 += f * f * inverse
        for k in range(X_C + d):
            f, v = -room.rb[k], vb[k]
            power += f * v
            speed2 += mb[k] * v * v
            force2 += f * f / mb[k]
        dt, keep, push = damp(kinetic, power, speed2, force2, memory)
        fastest = 0.0
        for i in range(1, n):
            inverse = push / mq[i]
            for k in range(d):
                v = keep * vq[i, k] - inverse * room.r[i, k]
                vq[i, k] = v
                fastest = max(fastest, abs(v))
        for k in range(X_C + d):
            vb[k] = keep * vb[k] - push * room.rb[k] / mb[k]
            if k >= X_C:
                fastest = max(fastest, abs(vb[k]))
        dt = min(dt, GAP_SHARE * gap / (fastest + 1e-300))
        for i in range(1, n):
            for k in range(d):
                q[i, k] += dt * vq[i, k]
        for k in range(X_C + d):
            b[k] += dt * vb[k]
        augment(physics, room, base, base_f, q, b)
        psi, sound = gradient(physics, mesh, q, b, psi, end_rotation, room)
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
