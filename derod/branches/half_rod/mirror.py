"""Mirror classes: which unknowns and conditions belong to planar states and to perturbations of
them.

A planar state has exact zeros in the odd class; the Jacobian splits into an even and an odd
block, and a pitchfork is a zero of the odd block's determinant. Loop planes of paths Ax, L_j are
the y-z plane (d_1 points out of it), that of Pt is the x-z plane. In states of the y-z plane q
has the components (q_w, q_x) where the middle tangent is +e_z, (q_y, q_z) where it is -e_z (odd
numbers of loops).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from derod.branches.half_rod import closure as row

X, Y, Z, QW, QX, QY, QZ, NX, NY, NZ = range(10)


@dataclass(frozen=True)
class Mirror:
    """One class of unknowns: state components, kept parameters and conditions."""

    name: str
    states: np.ndarray  # components of a node state
    parameters: np.ndarray  # among c_x, c_z, u3, sigma, as 10..13
    conditions: np.ndarray  # rows of closure.conditions

    @cached_property
    def kept(self) -> np.ndarray:
        """Columns of this class among the 37 kept unknowns, without delta, f_gamma and W."""
        d = self.states
        return np.concatenate([d, 10 + d, 20 + d, self.parameters + 20])

    @cached_property
    def closed(self) -> np.ndarray:
        """Columns of this class with delta and f_gamma."""
        return np.concatenate([self.kept, [row.DELTA, row.FGAMMA]])

    @property
    def carries_weight(self) -> bool:
        """Whether states of this class can balance a weight: n_y = W/2 is among their conditions."""
        return row.SIDEWAYS in self.conditions

    @cached_property
    def loaded(self) -> np.ndarray:
        """Columns of this class with delta, f_gamma and W."""
        return np.concatenate([self.closed, [row.WEIGHT]])


def _mirror(name: str, states: list[int], parameters: list[int], conditions: list[int]) -> Mirror:
    return Mirror(
        name, *(np.array(part, dtype=np.int64) for part in (states, parameters, conditions))
    )


_CX, _CZ, _U3, _SIGMA = 10, 11, 12, 13

FULL = _mirror("full", list(range(10)), [_CX, _CZ, _U3, _SIGMA], list(range(14)))

_AXIS_EVEN = [row.MIDDLE_Z, row.MIDDLE_NY, row.UNIT, row.SPHERE, row.SIDEWAYS, row.CLAMP_Z]
_AXIS_ODD = [row.MIDDLE_X, row.TWIST, row.CLAMP_X]

LOOP_EVEN = _mirror(
    "loop",
    [Y, Z, QW, QX, NY, NZ],
    [_CX, _SIGMA],
    [*_AXIS_EVEN, row.MIDDLE_QX, row.CLAMP_QX],
)
LOOP_ODD = _mirror(
    "out of the loop's plane",
    [X, QY, QZ, NX],
    [_CZ, _U3],
    [*_AXIS_ODD, row.MIDDLE_QZ, row.CLAMP_QY, row.CLAMP_TURN],
)
LOOP_BACK_EVEN = _mirror(
    "loop, middle reversed",
    [Y, Z, QY, QZ, NY, NZ],
    [_CX, _SIGMA],
    [*_AXIS_EVEN, row.MIDDLE_QZ, row.CLAMP_QY],
)
LOOP_BACK_ODD = _mirror(
    "out of the loop's plane, middle reversed",
    [X, QW, QX, NX],
    [_CZ, _U3],
    [*_AXIS_ODD, row.MIDDLE_QX, row.CLAMP_QX, row.CLAMP_TURN],
)
S_EVEN = _mirror(
    "point-symmetric curve",
    [X, Z, QW, QY, NX, NZ],
    [_SIGMA],
    [
        row.MIDDLE_X,
        row.MIDDLE_Z,
        row.UNIT,
        row.SPHERE,
        row.CLAMP_X,
        row.CLAMP_Z,
        row.CLAMP_QY,
    ],
)
S_ODD = _mirror(
    "out of the point-symmetric curve's plane",
    [Y, QX, QZ, NY],
    [_CX, _CZ, _U3],
    [
        row.MIDDLE_QX,
        row.MIDDLE_QZ,
        row.MIDDLE_NY,
        row.TWIST,
        row.SIDEWAYS,
        row.CLAMP_QX,
        row.CLAMP_TURN,
    ],
)

# Perturbations of the straight rod. Without twist the two planes decouple.
STRAIGHT_LOOP = _mirror(
    "straight to loop",
    [Y, QX, NY],
    [_CX],
    [row.MIDDLE_QX, row.MIDDLE_NY, row.SIDEWAYS, row.CLAMP_QX],
)
STRAIGHT_S = _mirror(
    "straight to point-symmetric curve",
    [X, QY, NX],
    [],
    [row.MIDDLE_X, row.CLAMP_X, row.CLAMP_QY],
)
STRAIGHT_TWISTED = _mirror(
    "twisted straight to space curve",
    [X, Y, QX, QY, NX, NY],
    [_CX],
    [
        row.MIDDLE_X,
        row.MIDDLE_QX,
        row.MIDDLE_NY,
        row.SIDEWAYS,
        row.CLAMP_X,
        row.CLAMP_QX,
        row.CLAMP_QY,
    ],
)

PLANES = ((LOOP_EVEN, LOOP_ODD), (LOOP_BACK_EVEN, LOOP_BACK_ODD), (S_EVEN, S_ODD))
"""(even, odd) classes of the planar states."""


def planes(weight: float) -> tuple[tuple[Mirror, Mirror], ...]:
    """The classes of PLANES that a drop of this weight has: a point-symmetric curve lies in a
    horizontal plane, and cannot carry any."""
    return PLANES if weight == 0.0 else PLANES[:2]
