r"""The Hessian with one border row more, regular at folds, factored once a step.

    H = [[K, v], [v^T, 0]],    J = [[K, -c], [v^T, g]]

K is the bordered band of ``rod.unknowns``, c the control's column, v the metric times a direction in the
space of displacements, g the control's part of the arclength's row. K is singular at a fold, H is not. J,
which is not symmetric, is solved with two solutions of H: with H (x1, s1) = (r, n) and H (x2, s2) = (c,
-g),

    dp = -s1 / s2,    dz = x1 + dp x2

(block elimination after Govaerts, *Numerical Methods for Bifurcations*, 2000, section 3). s2 is -det J /
det H: it vanishes only where another branch crosses. By Haynsworth's law K has the negative eigenvalues of
H, less one where the entry s s of the inverse of H is negative: the count costs nothing more.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from derod.algebra.bordered import factorize, new_factor, solve, solve_refined
from derod.equilibrium.control import Control
from derod.equilibrium.system import System
from derod.rod import assembly
from derod.rod.arrays import Linear
from derod.rod.state import State
from derod.rod.unknowns import F_A, MULTIPLIERS


class Vector(NamedTuple):
    """A vector in the space of the unknowns: rows like ``q[1:]``, and the border's."""

    rows: np.ndarray  # (N, d+1)
    border: np.ndarray  # (m,), of the Hessian's border

    def __add__(self, other: Vector) -> Vector:  # type: ignore[override]
        return Vector(self.rows + other.rows, self.border + other.border)

    def __sub__(self, other: Vector) -> Vector:
        return Vector(self.rows - other.rows, self.border - other.border)

    def times(self, factor: float) -> Vector:
        """Return the vector scaled."""
        return Vector(factor * self.rows, factor * self.border)

    def dot(self, other: Vector) -> float:
        """Return the plain inner product."""
        return float(np.vdot(self.rows, other.rows) + self.border @ other.border)


class Bordered:
    """The extended matrix of one system."""

    def __init__(self, system: System) -> None:
        self.system = system
        plain = system.room.linear
        rows, stride = plain.band.shape
        self.size = plain.border.shape[1]  # m, the border without the row of the arc
        wide = Linear(
            np.zeros((rows, stride)), np.zeros((rows, self.size + 1)),
            np.zeros((self.size + 1, self.size + 1)),
        )  # fmt: skip
        self.room = system.room._replace(linear=wide)
        self.factor = new_factor(rows, stride, self.size + 1)
        self.count = -1  # unstable modes at the state factored last
        self.critical = np.nan  # of the inverse, the entry of the new row

    def residual(self, state: State) -> Vector | None:
        """Return the residual with the clamped rows zero, None where it is not finite; psi follows."""
        system = self.system
        if not system.gradient(state):
            return None
        d = system.dimension
        out = Vector(system.room.r[1:, : system.width].copy(), np.zeros(self.size))
        end = out.rows[-1]
        end[: d - 1] = 0.0  # across the axis
        if not state.physics.slides:
            end[d - 1] = 0.0
        out.border[: system.room.rb.size] = system.room.rb
        return out

    def linearise(self, state: State, control: Control, direction: Vector) -> Vector | None:
        """Factor H at the state whose residual was taken last; return c, or None where H is singular.

        ``direction`` is v, already weighed by the metric.
        """
        system, linear = self.system, self.room.linear
        assembly.hessian(state.physics, state.q, state.b, state.holonomy, self.room)
        column = Vector(*control.column(system, state))
        flat = direction.rows.ravel()
        linear.border[: flat.size, -1] = flat
        linear.corner[-1, :-1] = linear.corner[:-1, -1] = direction.border
        linear.corner[-1, -1] = 0.0
        negative = factorize(linear, self.factor)
        if negative < 0:
            return None
        scale = self.factor.scale[-1]
        self.critical = float(scale * scale * self.factor.schur[-1, -1])
        idle = self.size - (F_A + system.dimension) - MULTIPLIERS  # helper rows
        self.count = negative - (self.critical < 0) - system.edges - MULTIPLIERS - idle
        return column

    def solve(self, right: Vector, last: float, *, refine: bool = True) -> tuple[Vector, float]:
        """Return (x, s) with H (x, s) = (right, last)."""
        factor = self.factor
        factor.rhs[:] = 0.0
        own = factor.rhs[: right.rows.size]
        own[:] = right.rows.ravel()
        factor.rhs_border[:-1] = right.border
        factor.rhs_border[-1] = last
        if refine:
            solve_refined(self.room.linear, factor)
        else:
            solve(factor, factor.rhs, factor.rhs_border)
        x = Vector(own.reshape(right.rows.shape).copy(), factor.rhs_border[:-1].copy())
        return x, float(factor.rhs_border[-1])
