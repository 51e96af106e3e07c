"""What events say of two states: how far the rod moved, and where its end went."""

from __future__ import annotations

import numpy as np

from derod.equilibrium.measured import Measured


def moved(before: Measured, after: Measured) -> str:
    """Say how far a node moved between two states."""
    d = before.state.dimension
    farthest = float(np.abs(after.state.q[:, :d] - before.state.q[:, :d]).max())
    return f"nodes moved {farthest:.3g} D"


def slid(before: Measured, after: Measured, lost: float) -> str:
    """Say where an end that slides went, and what energy was lost (K0/D)."""
    if not before.state.physics.slides:
        return ""
    start, end = before.state.end_shortening, after.state.end_shortening
    return f", end-shortening {start:.6g} to {end:.6g}, energy lost {lost:.6g}"


def after_semicolon(words: str) -> str:
    """Put words after a semicolon, if there are any."""
    return f"; {words}" if words else ""
