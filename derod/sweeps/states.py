"""What state a recorded rod is in: planar with n loops, or in space; and how many coils it has.

A configuration is planar where all nodes lie near one plane through the clamp axis. In its plane the unit
tangent turns from clamp to clamp through 2 pi n, and |n| is its number of loops: 0 of the paper's Ax, 2 of
L2. The number of coils is the rod's total turning over 2 pi, in space as in a plane, and no integer.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from derod.record.geometry import tangents_with_clamps

FLAT = 1e-4
"""D: the largest distance of a node from the plane of a planar state."""
IN_SPACE = -1
"""The number of loops of what is not planar."""


class Configuration(NamedTuple):
    """The state of one increment."""

    out_of_plane: float
    """The largest distance of a node from the rod's plane through the clamp axis, D."""
    loops: int
    """Of a planar state; ``IN_SPACE`` of others."""
    coils: float
    """Total turning over 2 pi."""


def configuration(positions: np.ndarray) -> Configuration:
    """The state of nodes (N+1, 3), D, clamped along e_z, with the start clamp on the axis x = y = 0."""
    across = positions[:, :2] - positions[0, :2]
    _, _, axes = np.linalg.svd(across, full_matrices=False)
    off = float(np.abs(across @ axes[1]).max())
    tangents = tangents_with_clamps(positions)
    cosines = np.einsum("ij,ij->i", tangents[1:], tangents[:-1])
    sines = np.linalg.norm(np.cross(tangents[1:], tangents[:-1]), axis=1)
    coils = float(np.arctan2(sines, cosines).sum() / (2.0 * np.pi))
    if off > FLAT:
        return Configuration(off, IN_SPACE, coils)
    angle = np.unwrap(np.arctan2(tangents[:, :2] @ axes[0], tangents[:, 2]))
    loops = abs(round(float(angle[-1] - angle[0]) / (2.0 * np.pi)))
    return Configuration(off, loops, coils)


def words(loops: int) -> str:
    """The state as a legend has it."""
    if loops == IN_SPACE:
        return "in space"
    if loops == 0:
        return "planar, no loop"
    return f"planar, {loops} loop{'s' if loops > 1 else ''}"
