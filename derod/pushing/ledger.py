r"""The law of a damped push: the energy never rises above the work of the control.

Along a branch dE = c dp, with the control p and its conjugate c (for the end-shortening, c = -t). Between
two settled states at a distance h the work is, by the trapezoid with its end correction,

    W = h (c_0 + c_1)/2 + h^2 (c_0' - c_1')/12,    c' = dc/dp,

and where c is convex or concave between them, also with a corner, the trapezoid is off by at most
h^2 |c_1' - c_0'| / 8. What is lost beyond that is a snap; what is gained, or a state that lies elsewhere than
the branch pointed, is a wrong step.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import StrEnum

from derod.equilibrium.measured import Measured

ROUNDING = 1e-9  # of the energies' size, below which they are equal
CORNER = 2.0  # times the bound: with a corner in between the end correction errs too
MOST_TURN = 2.0  # radians of holonomy in one increment; another link is 4 pi away


class Verdict(StrEnum):
    """What an entry of the ledger says."""

    BALANCED = "balanced"
    LOST = "lost"
    GAINED = "gained"
    JUMPED = "jumped"


@dataclass(frozen=True, slots=True)
class Entry:
    """Energy against work over one increment, K/D."""

    defect: float  # energy change minus work
    bound: float  # of the work's error
    turn: float  # radians, change of the holonomy; nan where it is free to jump

    @property
    def verdict(self) -> Verdict:
        """Say whether the step may stand."""
        if self.defect > self.bound:
            return Verdict.GAINED
        if self.defect < -self.bound:
            return Verdict.LOST
        if abs(self.turn) > MOST_TURN:
            return Verdict.JUMPED
        return Verdict.BALANCED

    @property
    def message(self) -> str:
        """Say it in words."""
        if self.verdict is Verdict.JUMPED:
            return f"the holonomy jumped by {self.turn:.3g} rad"
        return (
            f"energy {self.verdict} against the work of the control by {abs(self.defect):.3g} "
            f"(its error is at most {self.bound:.2g})"
        )


def compare(before: Measured, after: Measured, *, along: bool = True) -> Entry:
    """Hold the energy of a step from ``before`` against the work of the control.

    ``along`` says that both should lie on one branch; after a snap or a kick they need not.
    """
    h = after.control_value - before.control_value
    work = 0.5 * h * (before.conjugate + after.conjugate)
    work += h * h / 12 * (before.stiffness - after.stiffness)
    bend = abs(after.stiffness - before.stiffness)
    slope = min(abs(after.stiffness), abs(before.stiffness))
    change = abs(after.conjugate - before.conjugate)
    error = min(0.125 * h * h * bend, 0.5 * abs(h) * (change + abs(h) * slope))
    size = 1 + abs(before.energy) + abs(after.energy)
    return Entry(
        defect=after.energy - before.energy - work,
        bound=CORNER * error + ROUNDING * size,
        turn=after.state.holonomy - before.state.holonomy if along else math.nan,
    )
