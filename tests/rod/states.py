"""States far from equilibrium, for derivatives and invariances."""

from __future__ import annotations

import numpy as np

from derod.rod import arrays, assembly, frames
from derod.rod.arrays import Mesh
from derod.rod.grid import lay_grid
from derod.rod.mesh import dry_mesh, wetted_mesh
from derod.rod.physics import constants
from derod.scene.tables import Mesh as MeshOptions

LENGTH = 3.0
ROTATION = 1.0
LAYER = 0.2  # elastocapillary length, D
SECTION = {
    "angles": True,
    "section": 1.0,
    "stiffening": 2.5,
    "torsion": 0.7,
    "natural_curvature_1": 0.3,
    "natural_curvature_2": -0.4,
    "natural_twist": 0.5,
    "director_start": 0.3,
    "director_end": 0.8,
}


class Sample:
    """A state (q, b), its constants and room to work in."""

    def __init__(
        self,
        d: int,
        edges: int = 24,
        turns: float = 0.0,
        drop: bool = True,
        section: bool = False,
    ) -> None:
        self.physics = constants(
            d,
            LENGTH,
            drop=drop,
            twisting=0.0 if section else 0.9,
            end_rotation=ROTATION if d == 3 else 0.0,
            capillary_force=20.0,
            wall_strength=2e-2,
            wall_softness=0.1,
            weight=3.0,
            **(SECTION if section else {}),
        )
        self.w = len(self.physics.row)
        options = MeshOptions(edges=edges, inner_grading=0.3)
        self.mesh: Mesh = wetted_mesh(options, LAYER) if drop else dry_mesh(edges)
        self.room = arrays.new_room(self.mesh, self.physics)
        self.d, self.edges = d, edges
        self.psi = 0.0
        rng = np.random.default_rng(7)
        self.b = np.zeros(d + 5)
        self.q = arrays.new_q(edges, self.physics)
        if drop:
            self.b[0], self.b[1] = 1.05, 2.0
        lay_grid(self.mesh, LENGTH, self.b, self.room.kin)
        s = np.linspace(0, 1, edges + 1)
        self.q[1:, d - 1] = 0.85 * np.cumsum(self.room.kin.rest[1:-1])
        bump = 0.15 * np.sin(np.pi * s) ** 2
        self.q[:, d - 2] = bump * np.sin((7 + turns) * s)
        if d == 3:
            self.q[:, 0] = bump * np.cos((9 + turns) * s)
        self.q[0] = 0
        self.q[1:, d] = 5 * rng.normal(size=edges)
        if section:
            self.q[1:, d + 1] = 0.5 * rng.normal(size=edges)
            self.renew()
        if drop:
            self.b[1 + d] = self.q[edges // 2, d - 1]
            self.b[2 + d :] = 3.0, 4.0, 0.7

    def gradient(self, q: np.ndarray, b: np.ndarray) -> np.ndarray:
        """The residual as one vector: q's rows 1 ... N, then b."""
        psi, sound = assembly.gradient(self.physics, self.mesh, q, b, self.psi, self.room)
        assert sound
        self.followed = psi
        return np.concatenate([self.room.r[1:].ravel(), self.room.rb])

    def renew(self) -> None:
        """Count angles from the present tangents, where derivatives are local."""
        self.gradient(self.q, self.b)
        frames.renew(self.q, self.room.kin.tangent, self.room.kin.frames)

    def lagrangian(self, q: np.ndarray, b: np.ndarray) -> float:
        """Energies and constraints, put together without the gradient's code."""
        self.gradient(q, b)
        d, kin = self.d, self.room.kin
        energy = sum(assembly.energies(self.physics, q, b, self.followed, self.room))
        value = energy + q[1:, d] @ self.room.grad.constraint[1:-1]
        if self.physics.drop:
            for side, node in enumerate((kin.node_a, kin.node_b)):
                value += b[2 + d + side] * (np.sum((q[node, :d] - b[2 : 2 + d]) ** 2) - 0.25)
            value += b[4 + d] * (b[0] + b[1] - LENGTH)
        return value

    def dense(self) -> np.ndarray:
        """The bordered band matrix at the state, dense."""
        self.gradient(self.q, self.b)
        assembly.hessian(self.physics, self.q, self.b, self.followed, self.room)
        return dense(self.room.linear)

    def free(self) -> np.ndarray:
        """Places of the unknowns that may move: all but the end clamp's position."""
        n = self.w * self.edges
        held = range(n - self.w, n - self.w + self.d)
        return np.array([i for i in range(n + self.d + 5) if i not in held])


def dense(linear: arrays.Linear) -> np.ndarray:
    """A bordered band matrix as a dense one."""
    rows, stride = linear.band.shape
    n, m = rows - stride + 1, linear.corner.shape[0]
    matrix = np.zeros((n + m, n + m))
    for j in range(n):
        for k in range(min(stride, n - j)):
            matrix[j + k, j] = matrix[j, j + k] = linear.band[j, k]
    matrix[:n, n:] = linear.border[:n]
    matrix[n:, :n] = linear.border[:n].T
    matrix[n:, n:] = linear.corner
    return matrix
