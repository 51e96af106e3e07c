"""Images of a half-rod state under the problem's symmetries, and the plane of planar states."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from derod.branches.half_rod import closure as col
from derod.branches.half_rod.mirror import PLANES, Mirror
from derod.branches.half_rod.state import HalfRod

NODES = (col.NODE_0, col.NODE_SIGMA, col.NODE_END)
HALF_TURN = (-1, -1, 1, 1, -1, -1, 1, -1, -1, 1)
"""Signs of (w, q, n) under the half turn about the clamp axis, the frame turned with it."""
REFLECTION = (-1, 1, 1, 1, 1, -1, -1, -1, 1, 1)
"""Signs of (w, q, n) under x -> -x; moments and q's vector part are pseudo-vectors."""


def half_turned(state: HalfRod) -> HalfRod:
    """The state turned by pi about the clamp axis; its weight then pulls the other way."""
    signs = np.array(HALF_TURN, dtype=float)
    scalars = state.scalars * [-1.0, 1.0, 1.0, 1.0, 1.0, 1.0, -1.0]
    return replace(
        state, nodes=state.nodes * signs, stages=state.stages * signs[3:7], scalars=scalars
    )


def images(kept: np.ndarray) -> list[np.ndarray]:
    """The eight vectors (37,) of kept unknowns that are this state turned, reflected, or with -q.

    The half turn about e_z changes the sign of c_x and of the weight (with a weight it is no symmetry,
    and there are four images), the reflection x -> -x those of c_z and u3.
    Reflected states solve the same problem where the end rotation is 0 or 2 pi, where alone there
    are planar states.
    """
    out = []
    for turned in (False, True) if kept[col.WEIGHT] == 0.0 else (False,):
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
    """The image (37,) of ``kept`` nearest to ``other`` in a metric of squared ``weights`` (37,)."""
    return min(images(kept), key=lambda image: float(weights @ (image - other) ** 2))


def plane(state: HalfRod) -> tuple[Mirror, Mirror] | None:
    """The (even, odd) mirror classes of an exactly planar state, None for a space curve."""
    for even, odd in PLANES:
        if not state.nodes[:, odd.states].any() and not state.kept[odd.kept].any():
            return even, odd
    return None
