"""Newton's steps along a branch, H dz = -residual, and chord steps between them.

The state, stable or not, is trusted only within a region round the one that was predicted. Steps are limited
by the gap to the wall (a barrier), by the rotation of an edge and by the lengths of the three regions.

A chord step solves with the factor of the last Newton step. It takes the residual down by a share instead of
squaring it, and costs a sixth: near a solution two or three of them replace a Hessian and its factor, and
they mend what a solution without refinement left.
"""

from __future__ import annotations

from derod.algebra.bordered import factorize
from derod.algebra.copying import copy_rows, copy_vector
from derod.algebra.jit import inlined, kernel
from derod.equilibrium.lengths import correct_lengths, solve_lengths
from derod.equilibrium.limits import MOST_ROTATION, SHARP, beyond, longest_step, sharpest, try_step
from derod.equilibrium.linear import solve_step
from derod.equilibrium.steps import ACCEPTED, CHORD, REFINED, STALLED, STRAYED, UNSOUND
from derod.rod.assembly import gradient, hessian
from derod.rod.residual import excess
from derod.rod.terms.wall import wall_gap

FALL = 0.1  # of the residual, the least share of what the step takes away that a followed step must show
HALVINGS = 4  # of a followed step
CORRECTIONS = 3  # of a followed trial's lengths, before it is condemned
FARTHEST = 0.15  # D that a node may lie from where the branch was predicted
TURNED = 0.6  # rad that an edge may be turned from it
LEFT = 0.5  # of the residual, the most that a chord step may leave
POLISHED = 0.1  # of the tolerance: down to that go chord steps, where they still help
MORE = 4  # chord steps, in which the residual must be about to meet its tolerance: a Newton step costs more


@kernel
def begin_following(physics, mesh, tolerance, psi, room, q, b, work):
    """Take the residual of a predicted state; return (outcome, psi, excess, force residual)."""
    copy_rows(q, work.origin)
    psi, sound = gradient(physics, mesh, q, b, psi, room)
    level, force = excess(physics, room.r, room.rb, room.kin, tolerance)
    if not (sound and wall_gap(physics, room.kin, q, b) > 0):
        return UNSOUND, psi, level, force
    return ACCEPTED, psi, level, force


@kernel
def follow(physics, mesh, rules, most, coming, psi, room, factor, q, b, work):
    """Take at most ``most`` steps in place, until the residual meets its tolerance, within the region.

    A Newton step meets it by far, a chord step just so: others follow it, beyond ``most``, down to POLISHED.

    ``coming`` is the kind of the first: PLAIN to begin with, then REFINED, but CHORD where one is likely to
    help. Returns (outcome, Newton's steps among them, the kind to go on with, psi, excess, force residual);
    ``room`` holds the gradient, on entry and on return.
    """
    level, force = excess(physics, room.r, room.rb, room.kin, rules.tolerance)
    sharp = max(SHARP, sharpest(room.kin))
    done, hessians = 0, 0
    while (done < most and level > 1) or (coming == CHORD and 1 >= level > POLISHED):
        done += 1
        if coming == CHORD:
            before = level
            near, psi, level, force = chord_step(
                physics, mesh, rules, psi, level, force, sharp, room, factor, q, b, work
            )
            if not (near and level * (level / before) ** MORE <= 1):
                coming = REFINED
            continue
        hessians += 1
        refine = coming == REFINED
        outcome, psi, level, force = newton_step(
            physics, mesh, rules, psi, level, force, sharp, refine, room, factor, q, b, work
        )
        if outcome == STRAYED or (outcome == STALLED and refine):
            return outcome, hessians, coming, psi, level, force
        coming = CHORD if outcome == ACCEPTED else REFINED
    return ACCEPTED, hessians, coming, psi, level, force


@inlined
def newton_step(physics, mesh, rules, psi_old, old, force, sharp, refine, room, factor, q, b, work):
    """Take one Newton step in place, shortened until the residual falls.

    Returns (outcome, psi, excess, force residual).
    """
    hessian(physics, q, b, psi_old, room)
    if factorize(room.linear, factor) < 0:
        return STALLED, psi_old, old, force
    solve_step(physics, room, factor, work, refine)
    fraction = longest_step(physics, room.kin, q, b, work.dq, work.db, MOST_ROTATION)
    outcome = STALLED
    for _ in range(HALVINGS):
        try_step(physics, room.kin, fraction, q, b, work)
        for correction in range(CORRECTIONS + 1):
            if not wall_gap(physics, room.kin, work.tq, work.tb) > 0:
                break
            psi, sound = gradient(physics, mesh, work.tq, work.tb, psi_old, room)
            if not sound or sharpest(room.kin) > sharp:
                break
            new, new_force = excess(physics, room.r, room.rb, room.kin, rules.tolerance)
            if new < (1 - FALL * fraction) * old or new <= 1:
                if beyond(physics, room.kin, work.tq, work.origin, FARTHEST, TURNED):
                    outcome = STRAYED
                    break
                copy_rows(work.tq, q)
                copy_vector(work.tb, b)
                return ACCEPTED, psi, new, new_force
            if correction < CORRECTIONS:
                solve_lengths(physics, room, factor)
                correct_lengths(physics, room, factor, work.tq, work.tb)
        if outcome == STRAYED:
            break
        fraction *= 0.5
    gradient(physics, mesh, q, b, psi_old, room)
    return outcome, psi_old, old, force


@inlined
def chord_step(physics, mesh, rules, psi_old, old, force, sharp, room, factor, q, b, work):
    """Take a whole step with the factor at hand, if it keeps to the limits and the residual falls well.

    Returns (whether it was taken, psi, excess, force residual).
    """
    solve_step(physics, room, factor, work, False)
    if longest_step(physics, room.kin, q, b, work.dq, work.db, MOST_ROTATION) == 1.0:
        try_step(physics, room.kin, 1.0, q, b, work)
        if wall_gap(physics, room.kin, work.tq, work.tb) > 0:
            psi, sound = gradient(physics, mesh, work.tq, work.tb, psi_old, room)
            new, new_force = excess(physics, room.r, room.rb, room.kin, rules.tolerance)
            sound = sound and sharpest(room.kin) <= sharp and new <= LEFT * old
            if sound and not beyond(physics, room.kin, work.tq, work.origin, FARTHEST, TURNED):
                copy_rows(work.tq, q)
                copy_vector(work.tb, b)
                return True, psi, new, new_force
            gradient(physics, mesh, q, b, psi_old, room)
    return False, psi_old, old, force
