"""What can come of an attempt to settle a state."""

from __future__ import annotations


class NotConverged(ArithmeticError):  # noqa: N818 - an outcome: continuation takes a shorter step
    """A state could not be solved for, or not be meshed."""
