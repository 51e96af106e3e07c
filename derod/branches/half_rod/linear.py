"""The linearised half-rod problem in one mirror class: condense, eliminate, close, solve."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.linalg.lapack import dgesv

from derod.branches.half_rod import closure as col
from derod.branches.half_rod.chain import expand_chain, expand_stages, reduce_chain
from derod.branches.half_rod.closure import KEPT, ROWS, conditions, jump
from derod.branches.half_rod.condense import condense
from derod.branches.half_rod.element import INPUTS, PARAMETERS, STATE
from derod.branches.half_rod.gauss import STAGES
from derod.branches.half_rod.mirror import FULL, Mirror
from derod.branches.half_rod.state import HalfRod, Increment


@dataclass
class Elements:
    """All elements of a state linearised, shared by the mirror classes that look at it."""

    state: HalfRod
    A: np.ndarray  # (E, 10, 14)
    r: np.ndarray  # (E, 10)
    X: np.ndarray  # (E, 4 m, 15)
    jump_residual: np.ndarray  # (10,)
    jump_jacobian: np.ndarray  # (10, 11)
    meniscus_force: float  # f_B
    rows: np.ndarray  # (14,)
    rows_jacobian: np.ndarray  # (14, 37)
    gap: float  # least 1 + rho - 2 r
    residual: float  # largest of all equations


def linearise(state: HalfRod) -> Elements:
    """Linearise every element, the jump and the end conditions of a state."""
    prm = state.parameters
    count = state.eta.size
    A = np.zeros((count, STATE, INPUTS))
    r = np.zeros((count, STATE))
    X = np.empty((count, 4 * STAGES, INPUTS + 1))
    gap, stage_residual = condense(
        state.nodes,
        state.stages,
        state.eta,
        state.inner,
        0.5 * prm.length,
        state.scalars[:PARAMETERS],
        prm.section,
        prm.wall_strength,
        prm.wall_softness,
        A,
        r,
        X,
    )
    after, jacobian = np.empty(STATE), np.empty((STATE, STATE + 1))
    force = jump(state.nodes[state.inner], state.scalars[5], prm.meniscus_wall, after, jacobian)
    rows, rows_jacobian = np.empty(ROWS), np.empty((ROWS, KEPT))
    conditions(
        state.kept,
        0.5 * prm.length,
        prm.twisting,
        prm.end_rotation,
        after,
        jacobian,
        rows,
        rows_jacobian,
    )
    jump_residual = after - state.nodes[state.inner + 1]
    residual = max(stage_residual, np.abs(r).max(), np.abs(rows).max(), np.abs(jump_residual).max())
    return Elements(
        state, A, r, X, jump_residual, jacobian, force, rows, rows_jacobian, gap, float(residual)
    )


class Reduced:
    """The chain of one mirror class eliminated to a dense system in the kept unknowns.

    ``matrix`` (e, 37) and ``right`` (e,): chain relations and conditions of this class, all
    columns. ``columns``: the kept unknowns of this class, without delta, f_gamma and W.
    """

    def __init__(self, elements: Elements, mirror: Mirror = FULL) -> None:
        self.elements = elements
        self.mirror = mirror
        state = elements.state
        d, inputs = mirror.states, mirror.parameters
        size, count, inner = d.size, state.eta.size, state.inner
        width = 2 * size + inputs.size + 1
        self.kept_rows = np.empty((count, size, 3 * size + inputs.size + 1))
        wet, dry = np.empty((size, width)), np.empty((size, width))
        self.ends = np.zeros(count, dtype=np.int64)
        rest = (self.kept_rows, self.ends)
        flip = reduce_chain(elements.A, elements.r, 0, inner, d, inputs, wet, *rest)
        flip ^= reduce_chain(elements.A, elements.r, inner, count, d, inputs, dry, *rest)
        self.sign = -1.0 if flip else 1.0
        rows = mirror.conditions
        self.matrix = np.zeros((2 * size + rows.size, KEPT))
        self.right = np.empty(2 * size + rows.size)
        scalars = inputs + 20
        self.matrix[:size, d] = wet[:, :size]
        self.matrix[:size, 10 + d] = wet[:, size : 2 * size]
        self.matrix[:size, scalars] = wet[:, 2 * size : -1]
        self.right[:size] = wet[:, -1]
        entry = dry[:, :size]
        jacobian = elements.jump_jacobian[d]
        self.matrix[size : 2 * size, 10 + d] = entry @ jacobian[:, d]
        self.matrix[size : 2 * size, col.FGAMMA] = entry @ jacobian[:, 10]
        self.matrix[size : 2 * size, 20 + d] = dry[:, size : 2 * size]
        self.matrix[size : 2 * size, scalars] = dry[:, 2 * size : -1]
        self.right[size : 2 * size] = dry[:, -1] - entry @ elements.jump_residual[d]
        self.matrix[2 * size :] = elements.rows_jacobian[rows]
        self.right[2 * size :] = -elements.rows[rows]
        self.columns = mirror.kept

    def square(self) -> np.ndarray:
        """The block in this class's own unknowns (square for the odd classes)."""
        return self.matrix[:, self.columns]

    def determinant(self) -> float:
        """Determinant of the square block with the sign of the whole Jacobian's block (odd
        classes)."""
        return self.sign * float(np.linalg.det(self.square()))

    def solve(self, closing: np.ndarray, values: np.ndarray) -> np.ndarray:
        """Kept unknowns' increments (k, 37) for rows ``closing`` (c, 37) with right-hand sides.

        Two closing rows leave the weight as it is, with three it is one more unknown. ``values``
        (k, c + 1): the closing rows' values, and 1 for a Newton step or 0 for a derivative. Raises
        LinAlgError where the matrix is singular.
        """
        columns = self.mirror.closed if len(closing) == 2 else self.mirror.loaded
        count = self.right.size
        matrix = np.empty((count + len(closing), columns.size))
        matrix[:count] = self.matrix[:, columns]
        matrix[count:] = closing[:, columns]
        right = np.empty((count + len(closing), values.shape[0]))
        right[:count] = self.right[:, None] * values[:, -1]
        right[count:] = values[:, :-1].T
        _, _, solution, singular = dgesv(matrix, right)
        if singular:
            raise np.linalg.LinAlgError("singular matrix")
        out = np.zeros((values.shape[0], KEPT))
        out[:, columns] = solution.T
        return out

    def expand(self, kept: np.ndarray, own: float) -> Increment:
        """All increments from the kept ones; ``own`` = 1 for a Newton step, 0 for a derivative."""
        elements, d, inputs = self.elements, self.mirror.states, self.mirror.parameters
        state = elements.state
        inner, count = state.inner, state.eta.size
        dp = kept[col.CX : col.DELTA]
        nodes = np.zeros_like(state.nodes)
        nodes[0], nodes[inner], nodes[-1] = kept[0:10], kept[10:20], kept[20:30]
        step = elements.jump_jacobian[:, :10] @ kept[10:20]
        step += elements.jump_jacobian[:, 10] * kept[col.FGAMMA] + own * elements.jump_residual
        nodes[inner + 1, d] = step[d]
        chain = (self.kept_rows, self.ends, elements.A, elements.r)
        expand_chain(*chain, 0, inner, 0, d, inputs, dp, own, nodes)
        expand_chain(*chain, inner, count, inner + 1, d, inputs, dp, own, nodes)
        stages = np.empty_like(state.stages)
        expand_stages(elements.X, inner, nodes, dp, own, stages)
        return Increment(nodes, stages, kept[col.CX :].copy())
