"""Where every number of a state sits.

State
    ``q``, shape (N+1, d+1): row i is node i's position x_i (d numbers, D) followed by the tension
    (K/D^2) of the edge that ends there, lambda_i. Row 0 is the start clamp, with no tension.
    ``b``, shape (BORDER + d,): s_A, s_B, x_C (d), f_A, f_B and the slide force eta.
    d = 3, or 2 where the scene is planar; the clamp axis is the last coordinate, y the one before it.

    Where the section has directions of its own (``rod.frames``) a row of q goes on with the edge's
    angle theta (rad), an unknown, and six numbers that are none: the tangent and the director from which
    the angle is counted.

The bordered band matrix, w unknowns a row, w = d+1, or 5 with angles::

    unknown w(i-1)+k         q[i, k], i = 1 ... N: a band of half width 4d+2, or 19 with angles
    border  S_A, S_B         s_A, s_B                       \
            X_C + k          x_C, k = 0 ... d-1              | displacements: below F_A + d
            F_A + d, F_B + d f_A, f_B                        | multipliers
            ETA + d          eta                            /
            MOMENT + d       the twisting moment m_3         in space: makes k3/l grad psi grad psi a row
            TURN + d         the turn about the clamp axis   in space: deflated where it is neutral

Every constraint (N lengths, two menisci on the sphere, one slide) and each of the two helper rows in space
brings one negative eigenvalue; what is negative beyond those is an unstable mode.
"""

from __future__ import annotations

S_A, S_B, X_C = 0, 1, 2
F_A, F_B, ETA, BORDER = 2, 3, 4, 5
MULTIPLIERS = BORDER - F_A
MOMENT, TURN = 5, 6
HELPERS = 2  # rows in space
ANGLE, REFERENCE = 4, 5  # columns of q, in space
CARRIED = 6  # numbers of a row that are no unknowns


def half_width(d: int, *, angles: bool = False) -> int:
    """Return the half width of the band in d dimensions, with an angle an edge or without."""
    return 19 if angles else 4 * d + 2


def border_count(d: int) -> int:
    """Return the number of border rows in d dimensions."""
    return BORDER + d + (HELPERS if d == 3 else 0)
