"""One Newton step along a branch: H dz = -residual.

The state, stable or not, is trusted only within a region round the one that was predicted. Steps are limited
by the gap to the wall (a barrier), by the rotation of an edge and by the lengths of the three regions.
"""

from __future__ import annotations

from derod.algebra.bordered import factorize
from derod.algebra.copying import copy_rows, copy_vector
from derod.algebra.jit import kernel
from derod.equilibrium.lengths import correct_lengths, solve_lengths
from derod.equilibrium.limits import MOST_ROTATION, SHARP, beyond, longest_step, sharpest, try_step
from derod.equilibrium.linear import solve_step
from derod.equilibrium.steps import ACCEPTED, STALLED, STRAYED
from derod.rod.assembly import gradient, hessian
from derod.rod.residual import excess
from derod.rod.terms.wall import wall_gap

FALL = 0.1  # of the residual, the least share of what the step takes away that a followed step must show
HALVINGS = 4  # of a followed step
CORRECTIONS = 3  # of a followed trial's lengths, before it is condemned
FARTHEST = 0.15  # D that a node may lie from where the branch was predicted
TURNED = 0.6  # rad that an edge may be turned from it


@kernel
def follow_step(physics, mesh, rules, psi_old, room, factor, q, b, work):
    """Take one Newton step in place, shortened until the residual falls, within the region.

    Returns (outcome, psi, excess, force residual); ``room`` holds the gradient, on entry and on return.
    """
    old, force = excess(physics, room.r, room.rb, room.kin, rules.tolerance)
    sharp = max(SHARP, sharpest(room.kin))
    hessian(physics, q, b, psi_old, room)
    if factorize(room.linear, factor) < 0:
        return STALLED, psi_old, old, force
    solve_step(physics, room, factor, work)
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
