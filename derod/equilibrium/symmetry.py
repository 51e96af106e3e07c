r"""The symmetries that a settled state has, and how modes stand to them.

Two for rods between clamps of one axis, e_z. The flip runs the rod from its other end, turned by pi about a
line across the axis; with zeta = x + i y and the line at the angle phi,

    zeta(s) = e^{2 i phi} conj zeta(l - s),   z(s) = z_N - z(l - s)

The mirror at a plane through the axis at the angle alpha, zeta = e^{2 i alpha} conj zeta, is one where
the rod is planar and no twist is locked in it. A mode is even where the symmetry leaves it, odd where
it turns it into minus itself; under the mirror that is: in the plane, and out of it.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from derod.equilibrium.eigen import Eigenpairs
from derod.rod.state import State, in_space
from derod.rod.unknowns import BORDER, X_C

OWN = 1e-5  # relative, of what a symmetry may leave of a state
ON_AXIS = 1e-6  # of the length: a straight rod has every flip and every mirror
CLUSTER = 1e-5  # relative, of eigenvalues that count as one
PARITY = 1e-2  # of 1, that a mode's part may miss


class Symmetry(NamedTuple):
    """An orthogonal map of space, and whether it runs the rod backwards."""

    matrix: np.ndarray  # (3, 3)
    reverses: bool

    def of(self, nodes: np.ndarray) -> np.ndarray:
        """Return the image of displacements of nodes, (N+1, 3)."""
        return (nodes[::-1] if self.reverses else nodes) @ self.matrix


def reflection(angle: float, axial: float) -> np.ndarray:
    """Return the map that reflects at a line across the axis, at ``angle``, and multiplies z by ``axial``."""
    c, s = np.cos(2 * angle), np.sin(2 * angle)
    return np.array([[c, s, 0.0], [s, -c, 0.0], [0.0, 0.0, axial]])


def asymmetric(physics: Any) -> bool:
    """Return whether the section's directions leave the rod no symmetry of its centre line alone.

    They leave it where both clamps' d_1 lie along e_x, or both along e_y, and the rod is naturally straight.
    """
    shaped = physics.natural_curvature_1, physics.natural_curvature_2, physics.natural_twist
    start, end = physics.director_start, physics.director_end
    turned = max(abs(math.sin(2 * start)), abs(math.sin(end - start)))
    return any(shaped) or turned > OWN


def symmetries(state: State) -> tuple[Symmetry | None, Symmetry | None]:
    """Return the flip and the mirror of a state, None where it has none."""
    if asymmetric(state.physics):
        return None, None
    x = state.positions
    x[:, 2] -= 0.5 * x[-1, 2]
    points = x
    if state.physics.drop:
        points = np.vstack([x, state.drop_center - [0, 0, 0.5 * state.positions[-1, 2]]])
    zeta = x[:, 0] + 1j * x[:, 1]
    straight = np.abs(zeta).max() < ON_AXIS * state.physics.length
    heavy = state.physics.drop and state.physics.weight != 0

    def has(symmetry: Symmetry) -> bool:
        image = symmetry.of(x)
        if state.physics.drop:
            image = np.vstack([image, points[-1:] @ symmetry.matrix])
        keeps_down = not heavy or abs(symmetry.matrix[1, 1] - 1) < OWN
        return bool(keeps_down and np.abs(image - points).max() < OWN * np.abs(zeta).max())

    stiffness = (
        state.physics.twisting + state.physics.torsion
    )  # of one kind of section or the other
    twist = stiffness * (state.physics.end_rotation - state.holonomy)
    if straight:
        up = 0.5 * np.pi
        mirror = Symmetry(reflection(up, 1.0), False)
        return Symmetry(reflection(up, -1.0), True), mirror if abs(twist) < OWN else None
    flip = Symmetry(reflection(half_angle(zeta * zeta[::-1]), -1.0), True)
    mirror = Symmetry(reflection(half_angle(zeta * zeta), 1.0), False)
    untwisted = abs(twist) < OWN
    return flip if has(flip) else None, mirror if untwisted and has(mirror) else None


def half_angle(products: np.ndarray) -> float:
    """Return phi of e^{2 i phi}, the direction of a sum of complex numbers."""
    return 0.5 * float(np.angle(np.sum(products)))


def image_of(symmetry: Symmetry, pairs: Eigenpairs, weight: np.ndarray) -> np.ndarray:
    """Return the matrix of the symmetry among the modes, (k, k): products z_i . M g z_j.

    ``weight`` (N+1,) are the nodes' dual lengths; the places of the menisci follow by the constraints.
    """
    d = pairs.b.shape[1] - BORDER
    moved = in_space(pairs.q[:, :, :d])
    drop = in_space(pairs.b[:, X_C : X_C + d])
    image = np.stack([symmetry.of(one) for one in moved])
    size = np.sum(weight[:, None] * moved**2, axis=(1, 2)) + np.sum(drop**2, axis=1)
    out = np.einsum("n,ink,jnk->ij", weight, moved, image) + drop @ (drop @ symmetry.matrix).T
    return np.asarray(out / np.sqrt(np.outer(size, size)))


def aligned(state: State, pairs: Eigenpairs, weight: np.ndarray) -> Eigenpairs:
    """Return the modes, those of one eigenvalue combined so that each is even or odd."""
    flip, mirror = symmetries(state)
    q, b = pairs.q.copy(), pairs.b.copy()
    first = 0
    while first < pairs.values.size:
        last = first + 1
        size = 1 + abs(pairs.values[first])
        while (
            last < pairs.values.size and pairs.values[last] - pairs.values[first] < CLUSTER * size
        ):
            last += 1
        if last - first > 1:
            part = Eigenpairs(pairs.values[first:last], pairs.q[first:last], pairs.b[first:last])
            mixed = np.zeros((last - first, last - first))
            for factor, symmetry in ((1.0, mirror), (0.25, flip)):
                if symmetry is not None:
                    mixed += factor * image_of(symmetry, part, weight)
            _, turn = np.linalg.eigh(0.5 * (mixed + mixed.T))
            q[first:last] = np.einsum("ji,jnk->ink", turn[:, ::-1], part.q)
            b[first:last] = turn[:, ::-1].T @ part.b
        first = last
    return Eigenpairs(pairs.values, q, b)


def parities(state: State, pairs: Eigenpairs, weight: np.ndarray) -> tuple[list[str], list[str]]:
    """Return for each mode "even" or "odd" under the flip, and "in" or "out" of the plane.

    "" where the state does not have the symmetry, "mixed" where the mode has no part in it.
    """
    out = []
    for symmetry, words in zip(symmetries(state), (("even", "odd"), ("in", "out")), strict=True):
        if symmetry is None:
            out.append([""] * pairs.values.size)
            continue
        parts = np.diag(image_of(symmetry, pairs, weight))
        out.append(
            [
                words[0] if part > 1 - PARITY else words[1] if part < PARITY - 1 else "mixed"
                for part in parts
            ]
        )
    return out[0], out[1]
