"""Images of a state under the symmetries of its scene, the distance of two states, and duplicates.

A rod between clamps of one axis may be turned about that axis (unless the drop has a weight along -y),
flipped about a line across it, which runs the rod from its other end, and mirrored at a plane through the
axis where no end rotation is reversed by that.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from derod.equilibrium.turning import turns_freely
from derod.rod.state import State

SAME = 1e-5  # D, root mean square over the rod, of two states that are one


def images(state: State) -> Iterator[np.ndarray]:
    """Yield the nodes of the state's images, complex (N+1, 2): x + i y, and z."""
    x = state.positions
    across, along = x[:, 0] + 1j * x[:, 1], x[:, 2].astype(complex)
    for mirrored in (False, True) if abs(state.physics.end_rotation) < 1e-12 else (False,):
        # weight pulls along y: mirrors keep y, and the flip turns about the line along y
        u = -across.conj() if mirrored else across
        yield np.stack([u, along], axis=1)
        yield np.stack([-u.conj()[::-1], along[-1] - along[::-1]], axis=1)


def distance(state: State, other: State, weight: np.ndarray) -> float:
    """Return the least distance (D, root mean square) of a state from the images of another.

    ``weight`` has one entry a node, their dual lengths. The turn about the axis is the best one where
    turning is free.
    """
    own = next(images(state))
    share = weight / weight.sum()
    free = turns_freely(state)
    least = np.inf
    for image in images(other):
        u = image[:, 0]
        if free:
            overlap = np.sum(share * own[:, 0].conj() * u)
            if abs(overlap) > 1e-30:
                u = u * (overlap.conjugate() / abs(overlap))
        square = np.abs(own[:, 0] - u) ** 2 + np.abs(own[:, 1] - image[:, 1]) ** 2
        least = min(least, float(np.sqrt(np.sum(share * square))))
    return least


def node_weights(rest: np.ndarray) -> np.ndarray:
    """Return the dual lengths of all nodes, (N+1,), from rest lengths (N,)."""
    out = np.zeros(rest.size + 1)
    out[:-1] += 0.5 * rest
    out[1:] += 0.5 * rest
    return out


def character(state: State, weight: np.ndarray) -> str:
    """Return which symmetries a state has, in words: "planar, flip-even" and the like.

    Flip-even: it is its own image when run from the other end, after a half turn across the axis.
    Point-symmetric: after the reflection at its middle.
    """
    x = state.positions
    share = weight / weight.sum()
    middle = np.array([0.0, 0.0, 0.5 * x[-1, 2]])
    x = x - middle
    moment = (share[:, None] * x[:, :2]).T @ x[:, :2]
    values, vectors = np.linalg.eigh(moment)
    x = np.concatenate([x[:, :2] @ vectors, x[:, 2:]], axis=1)
    size = np.sqrt(max(values[1], 1e-30))
    words = ["straight" if size < SAME else "planar" if values[0] < SAME**2 else "spatial"]
    if words[0] != "straight":
        back = x[::-1]

        def own(*signs: float) -> bool:
            gap = np.sum(share[:, None] * (np.array(signs) * back - x) ** 2)
            return bool(np.sqrt(gap) < 10 * SAME)

        if words[0] == "planar":
            even, odd = own(1, 1, -1), own(1, -1, -1)
        else:
            even, odd = own(-1, 1, -1) or own(1, -1, -1), own(-1, -1, -1)
        words.append("flip-even" if even else "point-symmetric" if odd else "asymmetric")
    return ", ".join(words)
