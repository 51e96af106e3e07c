"""Explicit dynamic relaxation: fictitious masses, no time step and no damping constant to choose.

Inextensibility and the menisci's places are held by an augmented Lagrangian, mu = lambda + kappa g,
whose multipliers lambda are renewed whenever the forces have fallen by a factor, so that no strain is left
in the answer. ``masses`` makes the time step 1 stable. Damping is either

    FIRE (Bitzek et al. 2006, Guenole et al. 2020): the velocity is turned toward the force, the time
    step grows as long as the power F.v is positive
    kinetic (Cundall 1976, Barnes 1999): undamped, stopped at each peak of the kinetic energy

and both stop where the power changes sign, half a step back, which halves at least what overshot.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from derod.algebra.copying import scale_rows, scale_vector
from derod.algebra.jit import inlined, kernel
from derod.rod.assembly import constraints, forces
from derod.rod.residual import EPS, excess
from derod.rod.terms.wall import squared_distance, wall_gap
from derod.rod.unknowns import ETA, F_A, F_B, S_A, S_B, X_C

GAP_SHARE = 0.125  # of the least wall gap that a node may move in one step
ROTATION = 0.1  # rad that an edge may turn in one step
RENEW = 0.3  # forces fall by this between two renewals of the multipliers
STRAIN = 1e-3  # of the tolerance on forces, the relative one on lengths
LOOK = 10  # steps between two looks at the residual
FIRE_GROW, FIRE_CUT, FIRE_MIX, FIRE_FADE, FIRE_WAIT = 1.1, 0.5, 0.25, 0.99, 5
LEAST_STEP, LARGEST_STEP = 0.02, 1.0  # in units of the stable one
STEP, MIX, SINCE, LEVEL = 0, 1, 2, 3  # places in ``Motion.memory``


class Motion(NamedTuple):
    """Velocities and what the damping remembers."""

    velocity: np.ndarray  # (N+1, d) of the nodes, relative to what the wetted length carries
    momentum: np.ndarray  # (N+1, d)
    pull: np.ndarray  # (N+1, d) accelerations
    border: np.ndarray  # (1+d,) velocities of half the wetted length and of x_C
    border_pull: np.ndarray  # (1+d,)
    tension: np.ndarray  # (N+1,) lambda of the edges
    force: np.ndarray  # (2,) lambda of the menisci, f_A and f_B
    memory: (
        np.ndarray
    )  # (4,) time step, FIRE's mixing, steps since the stop, level of the next renewal


def new_motion(edges: int, d: int) -> Motion:
    """Return a state of rest."""
    return Motion(
        np.zeros((edges + 1, d)),
        np.zeros((edges + 1, d)),
        np.zeros((edges + 1, d)),
        np.zeros(1 + d),
        np.zeros(1 + d),
        np.zeros(edges + 1),
        np.zeros(2),
        np.array([0.1, FIRE_MIX, 0.0, 0.0]),
    )


@kernel
def evaluate(physics, mesh, psi, room, q, b, inertia, motion):
    """Set mu in q and b and the forces in ``room``; return (psi, sound)."""
    d = len(physics.axis)
    sound = constraints(physics, mesh, q, b, room)
    for e in range(1, q.shape[0]):
        q[e, d] = motion.tension[e] + inertia.penalty[e] * room.grad.constraint[e]
    for side in range(2 if physics.drop else 0):
        i = room.kin.node_a if side == 0 else room.kin.node_b
        off = squared_distance(physics, q, b, i) - 0.25
        b[F_A + d + side] = motion.force[side] + inertia.menisci[0] * off
    psi, finite = forces(physics, q, b, psi, room)
    slide = 0.5 * (room.rb[S_A] + room.rb[S_B])  # the menisci only move as mirror images
    b[ETA + d] -= slide
    room.rb[S_A] -= slide
    room.rb[S_B] -= slide
    return psi, sound and finite


@inlined
def accelerate(room, inertia, motion):
    """Fill the accelerations; return the power F.v, v.M v and F.M^-1 F."""
    r, rb = room.r, room.rb
    n, d = motion.velocity.shape[0] - 1, motion.velocity.shape[1]
    growth = rb[S_A] - rb[S_B]  # the force on half the wetted length
    power, speed2, force2 = 0.0, 0.0, 0.0
    for i in range(1, n):
        for k in range(d):
            f = -r[i, k]
            growth += f * inertia.carried[i, k]
            power += f * motion.velocity[i, k]
            speed2 += motion.momentum[i, k] * motion.velocity[i, k]
            a = 0.0
            for m in range(d):
                a -= inertia.inverse[i, k, m] * r[i, m]
            motion.pull[i, k] = a
            force2 += f * a
    for k in range(1 + d):
        f = growth if k == 0 else -rb[X_C + k - 1]
        mass = inertia.wetted[0] if k == 0 else inertia.centre[k - 1]
        v = motion.border[k]
        power += f * v
        speed2 += mass * v * v
        force2 += f * f / mass
        motion.border_pull[k] = f / mass
    return power, speed2, force2


@inlined
def damp(kinetic, speed2, force2, memory):
    """Return (factor on the velocity, factor on the acceleration) of this step; update the memory.

    FIRE's mixing, v <- (1 - alpha) v + alpha |v| F/|F|, is itself a step down the force, of length
    dt alpha |v|/|F|. Where soft modes move, |v|/|F| is large, and that step would be unstable for the stiff
    ones (they grow until the power turns negative, over and over): alpha is limited so that it is not.
    """
    memory[SINCE] += 1
    if memory[SINCE] == 1:  # from rest, half a kick
        return 0.0, 0.5 * memory[STEP]
    if kinetic:
        return 1.0, memory[STEP]
    if memory[SINCE] > FIRE_WAIT:
        memory[STEP] = min(FIRE_GROW * memory[STEP], LARGEST_STEP)
        memory[MIX] *= FIRE_FADE
    slowness = math.sqrt(speed2 / (force2 + 1e-300))
    mix = min(memory[MIX], 0.25 * memory[STEP] / (slowness + 1e-300))
    return 1 - mix, memory[STEP] + mix * slowness


@inlined
def stop(kinetic, memory):
    """Come to rest; FIRE's time step is cut."""
    memory[SINCE] = 0
    memory[MIX] = FIRE_MIX
    if not kinetic:
        memory[STEP] = max(FIRE_CUT * memory[STEP], LEAST_STEP)


@inlined
def push(room, keep, kick, motion):
    """Change the velocities to keep v + kick F/m; return (largest, fastest turn of an edge)."""
    n, d = motion.velocity.shape[0] - 1, motion.velocity.shape[1]
    fastest, turning = 0.0, 0.0
    for i in range(1, n + 1):
        square = 0.0
        for k in range(d):
            if i < n:
                motion.momentum[i, k] = keep * motion.momentum[i, k] - kick * room.r[i, k]
                motion.velocity[i, k] = keep * motion.velocity[i, k] + kick * motion.pull[i, k]
            v = motion.velocity[i, k]
            fastest = max(fastest, abs(v))
            square += (v - motion.velocity[i - 1, k]) ** 2
        turning = max(turning, square * room.kin.inverse[i] ** 2)
    for k in range(1 + d):
        motion.border[k] = keep * motion.border[k] + kick * motion.border_pull[k]
        fastest = max(fastest, abs(motion.border[k]))
    return fastest, math.sqrt(turning)


@inlined
def slow_down(factor, motion):
    """Scale the velocities."""
    scale_rows(factor, motion.velocity)
    scale_rows(factor, motion.momentum)
    scale_vector(factor, motion.border)


@inlined
def move(dt, q, b, inertia, motion):
    """Move the state along the velocities."""
    n, d = motion.velocity.shape[0] - 1, motion.velocity.shape[1]
    growth = dt * motion.border[0]
    for i in range(1, n):
        for k in range(d):
            q[i, k] += dt * motion.velocity[i, k] + growth * inertia.carried[i, k]
    b[S_A] -= growth
    b[S_B] += growth
    for k in range(d):
        b[X_C + k] += dt * motion.border[1 + k]


@inlined
def strain(physics, room, tolerance):
    """Return the largest ratio of a constraint's violation to what is allowed.

    The energy of a strained state is off by lambda g, to first order, while forces may be settled:
    lengths are held to a finer tolerance than forces.
    """
    d = len(physics.axis)
    rounding = 8 * EPS * physics.length
    worst = 0.0
    for e in range(1, room.r.shape[0]):
        worst = max(worst, abs(room.r[e, d]) / (tolerance * room.kin.rest[e] + rounding))
    for k in range(F_A + d, ETA + d):
        worst = max(worst, abs(room.rb[k]) / (tolerance + rounding))
    return worst


@kernel
def explicit_steps(physics, mesh, tolerance, kinetic, steps, psi, room, q, b, inertia, motion):
    """Move the state (q, b, psi) in place by up to ``steps`` damped steps.

    ``motion`` goes on from call to call. On return the gradient in ``room`` is that of the state.
    Returns (steps done, psi, excess, force residual, sound).
    """
    d = len(physics.axis)
    memory = motion.memory
    done, worst, force = 0, np.inf, np.inf
    while True:
        psi, sound = evaluate(physics, mesh, psi, room, q, b, inertia, motion)
        gap = wall_gap(physics, room.kin, q, b)
        sound = sound and gap > 0
        if not sound:
            break
        if done % LOOK == 0 or done == steps:
            worst, force = excess(physics, room.r, room.rb, room.kin, tolerance)
            strained = strain(physics, room, STRAIN * tolerance)
            if done == steps or (worst <= 1 and strained <= 1):
                worst = max(worst, strained)
                break
            # settled for these multipliers, or for good but for a strain that would show in the energy
            if worst <= 1 or force <= max(memory[LEVEL], 0.5 * tolerance):
                for e in range(1, q.shape[0]):
                    motion.tension[e] = q[e, d]
                motion.force[0], motion.force[1] = b[F_A + d], b[F_B + d]
                memory[LEVEL] = RENEW * force
        power, speed2, force2 = accelerate(room, inertia, motion)
        if memory[SINCE] > 0 and power <= 0:
            way = -0.5 * memory[STEP]
            stop(kinetic, memory)
        else:
            keep, kick = damp(kinetic, speed2, force2, memory)
            fastest, turning = push(room, keep, kick, motion)
            used = memory[STEP] * max(fastest / (GAP_SHARE * gap), turning / ROTATION)
            if used > 1:
                slow_down(1 / used, motion)
            way = memory[STEP]
        move(way, q, b, inertia, motion)
        done += 1
    return done, psi, worst, force, sound
