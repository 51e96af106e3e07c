"""The eigenvalues of the Hessian on the constraints that are nearest to zero, by subspace iteration.

    K u + (constraints) = mu M u

on the inverse that is at hand, with Rayleigh and Ritz's step in the metric M of
``equilibrium.stability.inertia``. The turn about the clamp axis, neutral on every state, is projected out;
sliding is pinned.
"""

from __future__ import annotations

import numpy as np

from derod.equilibrium.stability import inertia
from derod.equilibrium.system import System
from derod.equilibrium.turning import LEAST_TURNING, turning, turns_freely
from derod.rod.state import State
from derod.rod.unknowns import F_A
from derod.tracing.bordered import Vector

SPARE = 3  # vectors beyond those that are wanted
SWEEPS, SETTLED = 60, 1e-9  # at most; relative change of the eigenvalues wanted in the last one


def nearest_modes(
    system: System, state: State, count: int = 2, shift: float = 0.0
) -> tuple[np.ndarray, list[Vector]]:
    """Return the ``count`` eigenvalues (K/D^4) nearest to ``-shift`` and their modes, M-orthonormal.

    Modes have no multipliers. They come in the order of their distance from ``-shift``.
    """
    system.linearise(state, shift)
    weight, border_weight = inertia(system, state)
    if not state.physics.drop:
        border_weight[: F_A + system.dimension] = 0.0
    metric = np.concatenate([weight.ravel(), border_weight])
    turn = np.zeros_like(metric)
    if turns_freely(state):
        rows, border = turning(state, border_weight.size)
        motion = np.concatenate([rows.ravel(), border])
        size = np.sqrt(motion @ (metric * motion))
        turn = motion / size if size > LEAST_TURNING else turn
    rng = np.random.default_rng(0)
    block = rng.standard_normal((count + SPARE, metric.size)) * (metric > 0)
    block = orthonormal(without(block, turn, metric), metric)
    values = np.full(count, np.inf)
    for _ in range(SWEEPS):
        image = np.empty_like(block)
        for k, vector in enumerate(block):
            right = metric * vector
            rows, border = system.solve(
                right[: weight.size].reshape(weight.shape), right[weight.size :], refine=False
            )
            image[k] = np.concatenate([rows.ravel(), border]) * (metric > 0)
        image = without(image, turn, metric)
        small = (block * metric) @ image.T
        inverse, mix = np.linalg.eigh(0.5 * (small + small.T))
        order = np.argsort(-np.abs(inverse))
        before, values = values, 1 / inverse[order[:count]] - shift
        block = orthonormal(mix[:, order].T @ image, metric)
        if np.all(np.abs(values - before) <= SETTLED * (1 + np.abs(values))):
            break
    modes = [
        Vector(vector[: weight.size].reshape(weight.shape).copy(), vector[weight.size :].copy())
        for vector in block[:count]
    ]
    return values, modes


def without(block: np.ndarray, turn: np.ndarray, metric: np.ndarray) -> np.ndarray:
    """Return vectors with the turn projected out."""
    return np.asarray(block - np.outer(block @ (metric * turn), turn))


def orthonormal(block: np.ndarray, metric: np.ndarray) -> np.ndarray:
    """Return the rows of ``block`` made orthonormal in the metric, in their order."""
    out = block.copy()
    for _ in range(2):
        for k in range(len(out)):
            out[k] -= (out[:k] @ (metric * out[k])) @ out[:k]
            out[k] /= np.sqrt(out[k] @ (metric * out[k]))
    return out
