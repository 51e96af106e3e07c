r"""The lowest eigenpairs of the Hessian on the constraints, by shift-invert on the bordered band.

    H z = lambda M z,   A z = 0,   z.M z = int |u|^2 ds + D |x_C'|^2

u is the displacement of the rod's material: a node at arc length s moves by dx, but s moves with the menisci
by ds, and u = dx - t ds. So the norm is the rod's own, L2 along it by the nodes' dual lengths, and the
eigenvalues (K/D^4) do not know where the mesh has its nodes. The drop's centre counts like a rod of
length D. The constraints' rows A are the bordered matrix's, and so is their sign
in the count (``linear.unstable_modes``).

(H + sigma M), factored once with sigma so large that no eigenvalue is below -sigma (its inertia tells), is
solved with in Lanczos steps (ARPACK). Turning about the clamp axis, where it is neutral, is deflated by the
matrix's own row and projected out; the drop's slide is pinned by a constraint.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse.linalg import ArpackNoConvergence, LinearOperator, eigsh

from derod.equilibrium.linear import (
    ANGLE_INERTIA,
    FIRST_SHIFT,
    LARGEST_SHIFT,
    RAISE,
    unstable_modes,
)
from derod.equilibrium.system import System
from derod.equilibrium.turning import LEAST_TURNING, turning, turns_freely
from derod.errors import DerodError
from derod.rod.band import DEFLATION
from derod.rod.state import State
from derod.rod.unknowns import S_A, S_B, TURN, X_C

TOLERANCE = 1e-12  # of Lanczos, relative


class ModesError(DerodError, ValueError):
    """Modes that cannot be computed."""


class NotConvergedError(ModesError):
    """Lanczos steps that found no more eigenvalues within their limit."""


@dataclass(frozen=True, slots=True)
class Eigenpairs:
    """The k lowest eigenvalues and modes z.M z = 1, in the rod's units."""

    values: np.ndarray  # (k,) K/D^4, lowest first
    q: np.ndarray  # like a state's q, (k, N+1, ...), of places; what else a row has is zero
    b: np.ndarray  # (k, d+5) of s_A, s_B, x_C; zero for the multipliers


class Metric:
    """M at a state: M = P^T W P, where P takes unknowns to the displacements of material and drop.

    Taken from the system's kinematics: the state is the one whose ``gradient`` was taken last.
    """

    def __init__(self, system: System, state: State) -> None:
        kin, d, n = system.room.kin, system.dimension, system.edges
        rest = kin.rest
        self.d, self.nodes, self.drop = d, n, bool(state.physics.drop)
        weight = np.zeros((n, d))
        weight[:-1] = 0.5 * (rest[1:-2] + rest[2:-1])[:, None]
        if state.physics.slides:
            weight[-1, -1] = 0.5 * rest[-2]
        self.weight = weight
        self.root = np.sqrt(weight)
        tangent = kin.tangent[:, 1:] + kin.tangent[:, :-1]  # at the vertices 0 ... N
        tangent = (tangent / np.linalg.norm(tangent, axis=0))[:, 1:].T
        moved = np.cumsum(kin.slope[:, 1:-1], axis=1) if self.drop else np.zeros((2, n))
        self.carried = moved[:, :, None] * tangent  # (2, N, d) of the nodes by s_A, s_B
        self.width = state.width
        self.angle = np.repeat(ANGLE_INERTIA * rest[1:-1, None], state.width - d - 1, axis=1)
        self.free = np.concatenate(
            [weight.ravel() > 0, np.full(d, self.drop), np.full(self.angle.size, True)]
        )

    def down(self, rows: np.ndarray, border: np.ndarray) -> np.ndarray:
        """Return W^(1/2) P z, what moves, flat."""
        u = rows[:, : self.d] - border[S_A] * self.carried[0] - border[S_B] * self.carried[1]
        turned = np.sqrt(self.angle) * rows[:, self.d + 1 :]
        flat = np.concatenate([(self.root * u).ravel(), border[X_C : X_C + self.d], turned.ravel()])
        return np.asarray(flat[self.free])

    def up(self, moved: np.ndarray, border_size: int) -> tuple[np.ndarray, np.ndarray]:
        """Return P^T W^(1/2) v, like the rows of q and the border: the transpose of ``down``."""
        flat = np.zeros(self.free.size)
        flat[self.free] = moved
        rows, border = np.zeros((self.nodes, self.width)), np.zeros(border_size)
        places = self.root.size
        rows[:, : self.d] = self.root * flat[:places].reshape(self.nodes, self.d)
        turned = flat[places + self.d :].reshape(self.angle.shape)
        rows[:, self.d + 1 :] = np.sqrt(self.angle) * turned
        for s in (S_A, S_B):
            border[s] = -np.sum(self.carried[s] * rows[:, : self.d])
        border[X_C : X_C + self.d] = flat[places : places + self.d]
        return rows, border

    def weighed(self, rows: np.ndarray, border: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return M z."""
        return self.up(self.down(rows, border), border.size)

    def add_to(self, system: System, shift: float) -> None:
        """Add ``shift`` M to the matrix filled last."""
        linear, d, n = system.room.linear, self.d, self.nodes
        by_row = np.zeros((n, self.width))
        by_row[:, :d] = shift * self.weight
        by_row[:, d + 1 :] = shift * self.angle
        linear.band[: by_row.size, 0] += by_row.ravel()
        for s in (S_A, S_B):
            column = np.zeros((n, self.width))
            column[:, :d] = -shift * self.weight * self.carried[s]
            linear.border[: column.size, s] += column.ravel()
            for v in (S_A, S_B):
                linear.corner[s, v] += shift * np.sum(
                    self.weight * self.carried[s] * self.carried[v]
                )
        if self.drop:
            for k in range(d):
                linear.corner[X_C + k, X_C + k] += shift


def factor_shifted(system: System, state: State, shift: float) -> tuple[int, Metric]:
    """Factor H + ``shift`` M at a state; return how many eigenvalues lie below -shift, and M.

    The row of the turn is laid anew, so that it deflates it exactly in the metric of M, and lends it a
    stiffness of 1 + 2 |shift|, out of the count at any shift.
    """
    system.linearise(state)
    metric = Metric(system, state)
    metric.add_to(system, shift)
    if turns_freely(state):
        linear, turn = system.room.linear, TURN + state.dimension
        motion = turning(state, linear.corner.shape[0])
        rows, border = metric.weighed(*motion)
        linear.border[: rows.size, turn] = rows.ravel()
        linear.corner[turn], linear.corner[:, turn] = border, border
        square = np.sum(rows * motion[0]) + border @ motion[1]
        linear.corner[turn, turn] = -(square + DEFLATION) / (1 + 2 * abs(shift))
    return int(unstable_modes(state.physics, system.room.linear, system.factor)), metric


def most_modes(system: System, state: State) -> int:
    """Return how many modes may be asked for: half of what the constraints leave free."""
    d, n, physics = system.dimension, system.edges, state.physics
    return (d * (n - 1) + bool(physics.slides) + d * bool(physics.drop) - n) // 2


def lowest(system: System, state: State, k: int) -> Eigenpairs:
    """Return the ``k`` lowest eigenpairs at a settled state.

    Raises ``ModesError`` where there are not so many, or no shift makes the Hessian positive, and
    ``NotConvergedError``.
    """
    shift = FIRST_SHIFT
    below, metric = factor_shifted(system, state, shift)
    while below != 0:
        shift *= RAISE
        if shift > LARGEST_SHIFT:
            raise ModesError("no shift makes the Hessian positive")
        below, metric = factor_shifted(system, state, shift)
    size, moving = system.factor.rhs_border.size, int(metric.free.sum())
    most = most_modes(system, state)
    if not 1 <= k <= most:
        raise ModesError(f"k = {k}: allowed: 1 to {most}, on {system.edges} edges")
    turn = np.zeros(moving)
    if turns_freely(state):
        motion = metric.down(*turning(state, size))
        length = np.linalg.norm(motion)
        turn = motion / length if length > LEAST_TURNING else turn

    def solve(values: np.ndarray) -> np.ndarray:
        values = values.ravel()
        right = metric.up(values - (turn @ values) * turn, size)
        out = metric.down(*system.solve(*right))
        return np.asarray(out - (turn @ out) * turn)

    start = np.random.default_rng(0).standard_normal(moving)
    operator = LinearOperator((moving, moving), matvec=solve, dtype=float)
    try:
        inverse, vectors = eigsh(operator, k, which="LA", v0=start, tol=TOLERANCE)
    except ArpackNoConvergence as error:
        raise NotConvergedError(f"{len(error.eigenvalues)} of {k} modes converged") from error
    order = np.argsort(-inverse)
    q, b = np.zeros((k, *state.q.shape)), np.zeros((k, state.b.size))
    for number, column in enumerate(order):
        rows, border = system.solve(*metric.up(vectors[:, column], size))
        square = np.linalg.norm(metric.down(rows, border))
        q[number, 1:, : metric.d] = rows[:, : metric.d] / square
        b[number, : X_C + metric.d] = border[: X_C + metric.d] / square
    if not metric.drop:
        b[:] = 0.0
    return Eigenpairs(1 / inverse[order] - shift, q, b)
