"""Stability of settled states: sliding, and the lowest mode; ``measured`` counts unstable modes.

The Hessian of the Lagrangian on the constraints decides: its negative eigenvalues are counted by the
inertia of its factor. Turning the coil about the clamp axis is neutral and outside the count
(ARCHITECTURE.md, "Neutral modes").

Sliding the drop along the rod, both menisci by the same length c, is outside it too: s_A + s_B is
pinned. Its stiffness k = d^2E/dc^2, all else relaxed, falls like the square of the bending moment at
the clamps, exp(-2 sqrt(t) outer length), below what a mesh resolves. The pin's own entry of the inverse
tells it: released, s_A + s_B = 2 c, the matrix has one negative eigenvalue more where k < 0
(Haynsworth). That is counted by itself, ``slides``, where the moment at a clamp is above CLAMP_MOMENT:
the rule of the branches.
"""

from __future__ import annotations

import numpy as np

from derod.equilibrium.linear import ANGLE_INERTIA, FIRST_SHIFT, LARGEST_SHIFT
from derod.equilibrium.system import System
from derod.rod.state import State
from derod.rod.unknowns import ETA, F_A

CLAMP_MOMENT = 0.15  # K/D; above it sliding is resolved
HALVINGS = 3  # of the bracket of the lowest eigenvalue
SWEEPS, SETTLED = 30, 1e-10  # of inverse iteration, at most; relative change of its last one


def sliding_stiffness(system: System) -> float:
    """Return k = d^2E/dc^2 (K/D^3) of sliding the drop by c, from the matrix factored last."""
    if not system.physics.drop:
        return np.inf
    pin, factor = ETA + system.dimension, system.factor
    return float(-4.0 * factor.scale[pin] ** 2 * factor.schur[pin, pin])


def lowest_mode(
    system: System, state: State, start: np.ndarray
) -> tuple[float, np.ndarray, np.ndarray]:
    """Return the lowest eigenvalue on the constraints (K0/D^4) and its mode, shaped like q and b.

    Shifts bracket the eigenvalue (inertia), inverse iteration finds the vector. ``start`` has the shape
    of q: a vector that is not orthogonal to the mode; its sign decides the mode's. The mode's largest
    displacement is 1, its multipliers are zero.
    """
    low, high = 0.0, FIRST_SHIFT  # the lowest eigenvalue lies in (-high, -low)
    while system.linearise(state, high) > 0:
        low, high = high, 4 * high
        if high > LARGEST_SHIFT:
            return np.nan, np.zeros_like(state.q), np.zeros_like(state.b)
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        if system.linearise(state, middle) > 0:
            low = middle
        else:
            high = middle
    system.linearise(state, high)
    weight, border_weight = inertia(system, state)
    mode, border = start[1:, : state.width].copy(), np.zeros_like(border_weight)
    value = np.nan
    for _ in range(SWEEPS):
        right, right_border = weight * mode, border_weight * border
        new, new_border = system.solve(right, right_border)
        square = np.sum(right * mode) + right_border @ border
        before, value = value, square / (np.sum(right * new) + right_border @ new_border) - high
        largest = np.abs(new[weight > 0]).max()
        mode, border = new / largest, new_border / largest
        if abs(value - before) < SETTLED * high:
            break
    mode_q, mode_b = np.zeros_like(state.q), np.zeros_like(state.b)
    mode_q[1:, : state.width] = np.where(weight > 0, mode, 0.0)
    mode_b[: F_A + system.dimension] = border[: F_A + system.dimension]
    return float(value), mode_q, mode_b


def inertia(system: System, state: State) -> tuple[np.ndarray, np.ndarray]:
    """Return the metric of displacements: the nodes' dual lengths, ANGLE_INERTIA times an edge's for its
    angle, and 1 for the drop and the menisci.

    Shaped like the rows of q and the border; zero for multipliers and what is clamped.
    """
    rest = system.room.kin.rest
    d = system.dimension
    weight = np.zeros((system.edges, system.width))
    weight[:-1, :d] = 0.5 * (rest[1:-2] + rest[2:-1])[:, None]
    weight[:, d + 1 :] = ANGLE_INERTIA * rest[1:-1, None]
    if state.physics.slides:
        weight[-1, d - 1] = 0.5 * rest[-2]
    border = np.zeros_like(system.factor.rhs_border)
    border[: F_A + system.dimension] = 1.0
    return weight, border
