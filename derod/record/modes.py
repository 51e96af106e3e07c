"""The softest modes of a recorded increment: lowest eigenvalues of the Hessian on the constraints.

    H u + (constraints) = lambda M u

M weighs nodes by their dual lengths, the drop and the menisci by 1
(``derod.equilibrium.stability.inertia``). The Hessian, raised by a shift until it is positive (its inertia
tells), is factored once; Lanczos on its inverse finds the lowest eigenvalues. Sliding the drop along the rod
is pinned, as in the count of unstable modes. Turning about the clamp axis, neutral on every state, has only
the stiffness that the system's helper row lends it, and is projected out.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from scipy.sparse.linalg import LinearOperator, eigsh

from derod.equilibrium.linear import FIRST_SHIFT, LARGEST_SHIFT
from derod.equilibrium.stability import inertia
from derod.equilibrium.system import System
from derod.errors import DerodError
from derod.pushing.encode import decode
from derod.rod.state import State, in_space
from derod.rod.unknowns import F_A, S_A, S_B, X_C
from derod.scene.program import legs

if TYPE_CHECKING:
    from derod.record.run import BaseRun

TOLERANCE = 1e-12  # of Lanczos, relative
LEAST_TURNING = 1e-10  # D^1.5; below it the rod lies on the axis


class ModesError(DerodError, ValueError):
    """Modes that cannot be computed."""


@dataclass(frozen=True, repr=False)
class Modes:
    """The k lowest modes of an increment, softest first; negative eigenvalues are unstable."""

    eigenvalues: np.ndarray
    """(k,), K0/D^4."""
    shapes: np.ndarray
    """Displacements of the nodes, (k, N+1, 3); the largest component of each is 1."""
    menisci: np.ndarray
    """Changes of s_A and s_B, (k, 2)."""
    drop: np.ndarray
    """Displacements of the drop's centre, (k, 3)."""

    def __len__(self) -> int:
        return len(self.eigenvalues)

    def __repr__(self) -> str:
        values = ", ".join(f"{value:.6g}" for value in self.eigenvalues)
        return f"<{len(self)} modes: eigenvalues {values} K0/D^4>"


def modes(run: BaseRun, i: int, k: int) -> Modes:
    """See ``BaseRun.modes``."""
    system = System(run.scene)
    frame = run.frame_at(i)
    state = decode(system, frame, slides=legs(run.scene)[int(frame.row["segment"])].slides)
    shift = FIRST_SHIFT
    while system.linearise(state, shift) > 0:
        shift *= 4
        if shift > LARGEST_SHIFT:
            raise ModesError(f"increment {i}: no shift makes the Hessian positive")
    weight, border_weight = inertia(system, state)
    if (
        not system.physics.drop
    ):  # the rows of a drop that is not there have a stiffness of their own
        border_weight[: F_A + system.dimension] = 0.0
    metric = np.concatenate([weight.ravel(), border_weight])
    free = metric > 0
    root = np.sqrt(metric[free])
    most = (int(free.sum()) - system.edges) // 2
    if not 1 <= k <= most:
        raise ModesError(f"k = {k}: allowed: 1 to {most}, on {system.edges} edges")

    turn = root * turning(state, weight.shape, border_weight.size)[free]
    size = np.linalg.norm(turn)
    turn = turn / size if size > LEAST_TURNING else np.zeros_like(turn)

    def solve(values: np.ndarray) -> np.ndarray:
        values = values.ravel()
        full = np.zeros(metric.size)
        full[free] = root * (values - (turn @ values) * turn)
        rows, border = system.solve(full[: weight.size].reshape(weight.shape), full[weight.size :])
        out = root * np.concatenate([rows.ravel(), border])[free]
        return np.asarray(out - (turn @ out) * turn)

    start = np.random.default_rng(0).standard_normal(root.size)
    operator = LinearOperator((root.size, root.size), matvec=solve, dtype=float)
    inverse, vectors = eigsh(operator, k, which="LA", v0=start, tol=TOLERANCE)
    order = np.argsort(-inverse)
    vectors = (vectors / root[:, None])[:, order]
    full = np.zeros((k, metric.size))
    full[:, free] = vectors.T
    d = system.dimension
    nodes = np.zeros((k, system.edges + 1, d))
    nodes[:, 1:] = full[:, : weight.size].reshape(k, *weight.shape)[:, :, :d]
    borders = full[:, weight.size :]
    flat = nodes.reshape(k, -1)
    largest = flat[np.arange(k), np.abs(flat).argmax(axis=1)][:, None]
    borders = borders / largest
    return Modes(
        (1 / inverse[order] - shift) * system.bending,
        in_space(nodes / largest[:, :, None]),
        borders[:, [S_A, S_B]],
        in_space(borders[:, X_C : X_C + d]),
    )


def turning(state: State, shape: tuple[int, int], border: int) -> np.ndarray:
    """The displacement of a turn about the clamp axis, e_z x r, as rows of q and the border, flat."""
    d = state.dimension
    rows, more = np.zeros(shape), np.zeros(border)
    if d == 3:
        rows[:, 0], rows[:, 1] = -state.q[1:, 1], state.q[1:, 0]
        more[X_C], more[X_C + 1] = -state.b[X_C + 1], state.b[X_C]
    return np.concatenate([rows.ravel(), more])
