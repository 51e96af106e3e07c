"""What a settled state tells, read in one call: a call costs as much as the work on a small mesh."""

from __future__ import annotations

import numpy as np

from derod.algebra.jit import kernel
from derod.equilibrium.limits import sharpest
from derod.rod.assembly import energies
from derod.rod.residual import excess
from derod.rod.terms.wall import wall_gap


@kernel
def clamp_moment(kin):
    """Return the larger bending moment at a clamp (K/D), linearly from the two vertices beside it."""
    last = kin.rest.size - 1
    larger = 0.0
    for first, second, edge in ((0, 1, 1), (last - 1, last - 2, last - 1)):
        at_far = kin.rest[edge] + 0.25 * (1 / kin.weight[second] - 2 * kin.rest[edge])
        at_near = 0.25 * kin.rest[edge]
        square = 0.0
        for k in range(kin.change.shape[0]):
            near = 2 * kin.weight[first] * kin.change[k, first]  # the mean of [0, h/2]
            far = (
                2 * kin.weight[second] * kin.change[k, second]
            )  # of the cell around the first node
            square += (near - (far - near) * at_near / (at_far - at_near)) ** 2
        larger = max(larger, np.sqrt(square))
    return larger


@kernel
def readings(physics, room, q, b, psi, tolerance):
    """Return what a state tells whose Hessian was filled last.

    That is (the residual over its tolerance, the largest force in K/D^2, the largest 1 - cos of a turning
    angle, the wall's gap in D, the moment at a clamp in K/D, the energy of every term in K/D).
    """
    kin = room.kin
    level, force = excess(physics, room.r, room.rb, kin, tolerance)
    gap = wall_gap(physics, kin, q, b)
    return level, force, sharpest(kin), gap, clamp_moment(kin), energies(physics, q, b, psi, room)
