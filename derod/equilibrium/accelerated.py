r"""Explicit relaxation in the metric of ``elliptic``, its constraints projected out by the same solve.

One gradient and one solution a step. With the force F = -dL/d(x, s_A, s_B, x_C), the constraints g, the
velocity v and Nesterov's (1983) weights beta = k/(k+3), beta' = (k+1)/(k+4) after k steps,

    [[M, A^T], [A, 0]] [a, mu] = [h F, -(h/h_0 g + beta beta' A v) / (1 + beta')]
    v = beta v + a,   x += a + beta' v,   lambda += mu / h

so that A (a + beta' v) = -h/h_0 g: what corrects constraints is taken out of the velocity again one step
later. The rod comes to rest where the power F.v turns negative (O'Donoghue and Candes 2015, their
gradient scheme). Where that happens in the first step from rest, h was too long for a state that is far from
settled: it is halved, and grows back.

M and A are renewed when an edge has turned, a node's barrier has grown, or after some time. Where edges
are strained, as in a bad prediction, they are first brought back to their lengths at rest: the
multipliers of large corrections would make the rod buckle.
"""

from __future__ import annotations

import math

import numpy as np

from derod.algebra.bordered import solve
from derod.algebra.copying import copy_rows, copy_vector, scale_rows, scale_vector
from derod.algebra.jit import inlined, kernel
from derod.equilibrium.motion import (
    AGE,
    LARGEST_STEP,
    LEFT,
    RESTORED,
    SINCE,
    STEP,
    is_stale,
    left,
    power,
    renew,
    shape,
)
from derod.rod.assembly import gradient
from derod.rod.residual import EPS, excess
from derod.rod.terms.wall import stay_inside, wall_gap
from derod.rod.unknowns import BORDER, F_A, S_A, S_B, X_C

LEAST_STEP = LARGEST_STEP / 64
GROW = 1.2
MOST_ROTATION = 0.05  # rad of an edge in one step; lengths are off by its square
MOST_GAP_USED = 0.25
MOST_REGION_USED = 0.25
STRAINED = 1e-2  # of an edge, beyond which lengths come first
MOST_RESTORED = 50  # steps that only bring back lengths, in one relaxation
SHARPEST = 1.0  # of 1 - cos phi: a vertex bent by more than a right angle is no rod


@inlined
def accelerate(r, rb, h, ease, keep, more, factor, motion):
    """Solve for a and mu (in ``factor``'s right sides), with ``ease`` of g; return F.a."""
    d, n = motion.velocity.shape[1] - 1, motion.velocity.shape[0] - 1
    v, vb = motion.velocity, motion.border
    x, y = factor.rhs, factor.rhs_border
    x[:] = 0.0
    y[:] = 0.0
    scale = 1 / (1 + more)
    for i in range(1, n + 1):
        j = (d + 1) * (i - 1)
        if i < n:
            for k in range(d):
                x[j + k] = -h * r[i, k]
        x[j + d] = -scale * (ease * r[i, d] + keep * more * v[i, d])
        v[i, d] = keep * v[i, d] + x[j + d]
    for k in range(BORDER + d):
        if k < F_A + d:
            y[k] = -h * rb[k]
        else:
            y[k] = -scale * (ease * rb[k] + keep * more * vb[k])
            vb[k] = keep * vb[k] + y[k]
    solve(factor, x, y)
    work = 0.0
    for i in range(1, n):
        for k in range(d):
            work -= r[i, k] * x[(d + 1) * (i - 1) + k]
    for k in range(F_A + d):
        work -= rb[k] * y[k]
    return work


@inlined
def longest_step(physics, kin, q, b, x, y):
    """Return the fraction of the step (x, y) that stays inside the limits, at most 1."""
    d, n = kin.tangent.shape[0], kin.rest.size - 2
    fraction = 1.0
    for e in range(1, n + 1):
        square = 0.0
        for k in range(d):
            start = x[(d + 1) * (e - 2) + k] if e > 1 else 0.0
            square += (x[(d + 1) * (e - 1) + k] - start) ** 2
        fraction = min(fraction, MOST_ROTATION * kin.rest[e] / (math.sqrt(square) + 1e-300))
    for i in range(kin.node_a, kin.node_b + 1):
        r2, outward = 0.0, 0.0
        for k in range(d):
            z = q[i, k] - b[X_C + k]
            r2 += z * z
            outward += z * (x[(d + 1) * (i - 1) + k] - y[X_C + k])
        r = math.sqrt(r2) + 1e-300
        outward *= 2 / r
        if outward > 0:
            gap = 1 + physics.wall_softness - 2 * r
            fraction = min(fraction, MOST_GAP_USED * gap / outward)
    if physics.drop:
        for region, change in (
            (b[S_A], -y[S_A]),
            (b[S_B] - b[S_A], y[S_A] - y[S_B]),
            (physics.length - b[S_B], y[S_B]),
        ):
            if change > 0:
                fraction = min(fraction, MOST_REGION_USED * region / change)
    return fraction


@inlined
def move(physics, kin, h, keep, more, factor, q, b, motion):
    """Renew multipliers (unless h is 0) and velocities, and move the state within the limits."""
    d, n = q.shape[1] - 1, q.shape[0] - 1
    v, vb = motion.velocity, motion.border
    x, y = factor.rhs, factor.rhs_border
    for i in range(1, n + 1):
        j = (d + 1) * (i - 1)
        for k in range(d):
            v[i, k] = keep * v[i, k] + x[j + k] if i < n else 0.0
            x[j + k] += more * v[i, k]
        if h > 0:
            q[i, d] += x[j + d] / h
    for k in range(F_A + d):
        vb[k] = keep * vb[k] + y[k]
        y[k] += more * vb[k]
    if h > 0:
        for k in range(F_A + d, BORDER + d):
            b[k] += y[k] / h
    fraction = longest_step(physics, kin, q, b, x, y)
    if fraction < 1:
        scale_rows(fraction, v)
        scale_vector(fraction, vb)
    copy_rows(q, motion.old_q)
    copy_vector(b, motion.old_b)
    for i in range(1, n):
        for k in range(d):
            q[i, k] += fraction * x[(d + 1) * (i - 1) + k]
    for k in range(F_A + d):
        b[k] += fraction * y[k]
    if physics.drop:
        stay_inside(physics, kin, motion.old_q, motion.old_b, q, b)


@inlined
def rest(motion):
    """Come to rest."""
    scale_rows(0.0, motion.velocity)
    scale_vector(0.0, motion.border)
    motion.memory[SINCE] = 0


@kernel
def accelerated_steps(physics, mesh, tolerance, steps, psi, room, factor, q, b, motion):
    """Move the state (q, b, psi) in place by up to ``steps`` steps, until it is settled.

    ``motion`` goes on from call to call. On return the gradient in ``room`` is that of the state.
    Returns (steps done, psi, excess, force residual, alive, sound).
    """
    memory = motion.memory
    kin = room.kin
    done, worst, force, alive = 0, np.inf, np.inf, True
    while True:
        psi, sound = gradient(physics, mesh, q, b, psi, room)
        sound = sound and wall_gap(physics, kin, q, b) > 0
        if not sound:
            break
        worst, force = excess(physics, room.r, room.rb, kin, tolerance)
        strain, sharpest = shape(kin, room.r)
        restore = strain > STRAINED
        alive = sharpest < SHARPEST and memory[RESTORED] < MOST_RESTORED
        if not alive:
            worst = max(worst, 1 + EPS)  # stuck is not settled
            break
        if done == steps:
            worst = max(worst, memory[LEFT])
            break
        if restore or is_stale(kin, room.hess, motion):
            renew(physics, q, b, room, factor, motion)
        memory[AGE] += 1
        moving = memory[SINCE] > 0
        if moving and power(room.r, room.rb, motion) <= 0:
            if memory[SINCE] == 1:
                memory[STEP] = max(0.5 * memory[STEP], LEAST_STEP)
            rest(motion)
        elif memory[SINCE] > 1:
            memory[STEP] = min(GROW * memory[STEP], LARGEST_STEP)
        if restore:
            rest(motion)
            memory[RESTORED] += 1
            memory[LEFT] = np.inf
            accelerate(room.r, room.rb, 0.0, 1.0, 0.0, 0.0, factor, motion)
            move(physics, kin, 0.0, 0.0, 0.0, factor, q, b, motion)
            rest(motion)
        else:
            h, since = memory[STEP], memory[SINCE]
            keep, more = since / (since + 3), (since + 1) / (since + 4)
            work = accelerate(room.r, room.rb, h, h / LARGEST_STEP, keep, more, factor, motion)
            memory[LEFT] = left(physics, kin, work / h, tolerance)
            if worst <= 1 and memory[LEFT] <= 1:
                worst = max(worst, memory[LEFT])
                break
            move(physics, kin, h, keep, more, factor, q, b, motion)
            memory[SINCE] += 1
        done += 1
    return done, psi, worst, force, alive, sound
