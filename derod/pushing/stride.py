"""How long the next increment shall be: by how hard the last one was."""

from __future__ import annotations

import sys

FIRST = 0.1  # of the largest
LEAST = 1e-4  # of the largest
SHORT = 0.05  # of the largest; increments that converge are not made shorter than this
GROW, SHRINK = 1.5, 0.5
FOLD = (
    0.05  # of the largest, and of the control's usual step: a fold is passed by no longer increment
)


class Stride:
    """The length of increments on one leg, in the control's unit."""

    def __init__(self, largest: float, usual: float) -> None:
        self.largest = largest
        self.usual = usual
        self.length = FIRST * largest

    @property
    def least(self) -> float:
        """Return the length below which an increment is given up."""
        return LEAST * self.largest

    def shortest(self, *, stable: bool) -> float:
        """Return the length of an increment that ends in a descent if the branch ends within it."""
        return min(FOLD * self.largest, FOLD * self.usual) if stable else self.least

    def start_again(self) -> None:
        """Begin with short increments, after a jump."""
        self.length = FIRST * self.largest

    def shorten(self, length: float, shortest: float = 0.0) -> None:
        """Retry an increment of ``length`` that may not stand."""
        self.length = max(SHRINK * length, 0.99 * shortest)

    def adapt(self, length: float, *, hard: bool, easy: bool) -> None:
        """Set the next length from how hard an increment of ``length`` was."""
        if hard:
            self.length = max(SHRINK * length, SHORT * self.largest)
        elif easy and length > 0.5 * self.length:
            self.length = min(GROW * self.length, self.largest)

    def target(self, here: float, goal: float) -> float:
        """Return where the next increment ends: a stride on, or the goal, or half way where it is near."""
        distance = abs(goal - here)
        step = self.length
        if step >= distance * (1 - 1e-9):
            return goal
        if 2 * step > distance:
            step = 0.5 * distance
        return here + step if goal > here else here - step


def same_place(a: float, b: float) -> bool:
    """Return whether two values of a control are the same but for the rounding of a change of units."""
    return abs(a - b) <= 4 * sys.float_info.epsilon * max(abs(a), abs(b))
