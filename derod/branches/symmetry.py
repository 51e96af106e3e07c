"""Images of a half-rod state under the problem's symmetries, and the plane of planar states."""

from __future__ import annotations

import numpy as np

from derod.branches import closure as col
from derod.branches.mirror import PLANES, Mirror
from derod.branches.state import HalfRod

NODES = (col.NODE_0, col.NODE_SIGMA, col.NODE_END)
HALF_TURN = (-1, -1, 1, 1, -1, -1, 1, -1, -1, 1)
"""Signs of (w, q, n) under the half turn about the clamp axis, the frame turned with it."""
REFLECTION = (-1, 1, 1, 1, 1, -1, -1, -1, 1, 1)
"""Signs of (w, q, n) under x -> -x; moments and q's vector part are pseudo-vectors."""


def images(kept: np.ndarray) -> list[np.ndarray]:
    """The eight vectors (36,) of kept unknowns that are this state turned, reflected, or with -q.

    The half turn about e_z changes the sign of c_x, the reflection x -> -x those of c_z and u3.
    Reflected states solve the same problem where the end rotation is 0 or 2 pi, where alone there
    are planar states.
    """
    out = []
    for turned in (False, True):
        for reflected in (False, True):
            for sign in (1.0, -1.0):
                node = np.ones(10)
                image = kept.copy()
                if turned:
                    node *= HALF_TURN
                    image[col.CX] *= -1.0
                if reflected:
                    node *= REFLECTION
                    image[[col.CZ, col.U3]] *= -1.0
                node[3:7] *= sign
                for first in NODES:
                    image[first : first + 10] *= node
                out.append(image)
    return out


def nearest_image(kept: np.ndarray, other: np.ndarray, weights: np.ndarray) -> np.ndarray:
    """The image (36,) of ``kept`` nearest to ``other`` in a metric of squared ``weights`` (36,)."""
    return min(images(kept), key=lambda image: float(weights @ (image - other) ** 2))


def plane(state: HalfRod) -> tuple[Mirror, Mirror] | None:
    """The (even, odd) mirror classes of an exactly planar state, None for a space curve."""
    for even, odd in PLANES:
        if not state.nodes[:, odd.states].any() and not state.kept[odd.kept].any():
            return even, odd
    return None
