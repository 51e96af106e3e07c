"""The state of the rod and the drop, and the constants it was settled or guessed with."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from derod.rod.unknowns import ANGLE, ETA, F_A, F_B, S_A, S_B, X_C


@dataclass(slots=True)
class State:
    """Unknowns of the discrete rod, in the arrays the kernels work on (``rod.unknowns``)."""

    q: (
        np.ndarray
    )  # (N+1, d+1): positions, and the tension of the edge that ends there; more with angles
    b: np.ndarray  # (d+5,): s_A, s_B, x_C, f_A, f_B, eta
    holonomy: float  # psi, radians, on the branch followed so far
    end_shortening: float  # delta, D; where the end slides, as far as the last relaxation took it
    physics: Any  # the constants (``rod.physics``), those that controls change among them

    @property
    def dimension(self) -> int:
        """Return d, 2 or 3."""
        return len(self.physics.axis)

    @property
    def width(self) -> int:
        """Return w, the unknowns of a row of q."""
        return len(self.physics.row)

    @property
    def menisci(self) -> tuple[float, float]:
        """Return s_A, s_B, D."""
        return float(self.b[S_A]), float(self.b[S_B])

    @property
    def forces(self) -> tuple[float, float]:
        """Return f_A, f_B, K0/D^2."""
        d = self.dimension
        return float(self.b[F_A + d]), float(self.b[F_B + d])

    @property
    def slide_force(self) -> float:
        """Return eta, K0/D^2."""
        return float(self.b[ETA + self.dimension])

    @property
    def positions(self) -> np.ndarray:
        """Return a copy of the nodes, (N+1, 3), D; a planar rod lies in the y-z plane."""
        return in_space(self.q[:, : self.dimension])

    @property
    def drop_center(self) -> np.ndarray:
        """Return x_C, (3,), D."""
        return in_space(self.b[X_C : X_C + self.dimension])

    @property
    def edge_tension(self) -> np.ndarray:
        """Return a copy of the tensions, (N,), K0/D^2."""
        return self.q[1:, self.dimension].copy()

    @property
    def edge_frame(self) -> np.ndarray | None:
        """Return a copy of angles and references, (N, 7), of a section with directions; else None."""
        return self.q[1:, ANGLE:].copy() if self.width > self.dimension + 1 else None

    def equals(self, other: State) -> bool:
        """Return whether the other state is the same to the last bit."""
        return (
            np.array_equal(self.q, other.q)
            and np.array_equal(self.b, other.b)
            and (self.holonomy, self.end_shortening) == (other.holonomy, other.end_shortening)
            and bool(self.physics == other.physics)
        )

    def copy(self) -> State:
        """Return a state that shares no array with this one."""
        return State(self.q.copy(), self.b.copy(), self.holonomy, self.end_shortening, self.physics)

    def take(self, other: State) -> None:
        """Become the other state."""
        self.q[:], self.b[:] = other.q, other.b
        self.holonomy, self.end_shortening = other.holonomy, other.end_shortening
        self.physics = other.physics

    def clamp_at(self, end_shortening: float) -> None:
        """Put the end clamp where ``end_shortening`` (D) wants it; the rest is left as it is."""
        self.q[-1, : self.dimension] = 0.0
        self.q[-1, self.dimension - 1] = self.physics.length - end_shortening
        self.end_shortening = end_shortening

    def read_end(self) -> None:
        """Take the end-shortening from where the end has slid to, if it slides."""
        if self.physics.slides:
            self.end_shortening = float(self.physics.length - self.q[-1, self.dimension - 1])


def in_space(vectors: np.ndarray) -> np.ndarray:
    """Return vectors (..., d) as (..., 3), planar ones in the y-z plane."""
    if vectors.shape[-1] == 3:
        return vectors.copy()
    return np.concatenate([np.zeros((*vectors.shape[:-1], 1)), vectors], axis=-1)
