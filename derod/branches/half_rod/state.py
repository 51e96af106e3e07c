"""A half-rod state: mesh, node states, stage quaternions and the scalars of the problem."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from derod.branches.half_rod import closure as col
from derod.branches.half_rod.parameters import Parameters


@dataclass(frozen=True)
class HalfRod:
    """An approximate or settled state of the half rod s in [0, l/2].

    ``eta`` (E,): element lengths, fractions of [0, sigma] for the first ``inner`` elements and of
    [sigma, l/2] for the rest. ``nodes`` (E+2, 10): w = r - r_C, q, n at element ends, the meniscus
    twice (before and after the jump). ``stages`` (E, m, 4): quaternions at the Gauss points.
    ``scalars`` (7,): c_x, c_z, u3, sigma, delta, f_gamma, W (f_gamma and W may differ from the
    parameters' own while a path is sought in another liquid, or with a lighter drop). Arrays are not
    changed once they are here.
    """

    parameters: Parameters
    eta: np.ndarray
    inner: int
    nodes: np.ndarray
    stages: np.ndarray
    scalars: np.ndarray

    @property
    def sigma(self) -> float:
        """Half of the wetted length (D)."""
        return float(self.scalars[3])

    @property
    def end_shortening(self) -> float:
        """Delta (D)."""
        return float(self.scalars[4])

    @property
    def weight(self) -> float:
        """W, the weight of the drop (K0/D^2)."""
        return float(self.scalars[6])

    @property
    def end_tension(self) -> float:
        """T = n(l/2) . d_3(l/2) = n_z(l/2) (K0/D^2)."""
        return float(self.nodes[-1, 9])

    @cached_property
    def kept(self) -> np.ndarray:
        """The 37 unknowns of ``closure``."""
        ends = self.nodes[[0, self.inner, -1]].ravel()
        return np.concatenate([ends, self.scalars])

    @cached_property
    def lengths(self) -> np.ndarray:
        """Element lengths (E,), D."""
        h = self.eta * self.sigma
        h[self.inner :] = self.eta[self.inner :] * (0.5 * self.parameters.length - self.sigma)
        return h

    @cached_property
    def node_arc_length(self) -> np.ndarray:
        """Arc length from the middle of every node, the meniscus twice (E+2,), D."""
        s = np.concatenate([[0.0], np.cumsum(self.lengths)])
        return np.insert(s, self.inner, s[self.inner])

    def moved(self, step: Increment, factor: float = 1.0) -> HalfRod:
        """This state plus ``factor`` times an increment."""
        return replace(
            self,
            nodes=self.nodes + factor * step.nodes,
            stages=self.stages + factor * step.stages,
            scalars=self.scalars + factor * step.scalars,
        )

    def with_parameters(self, parameters: Parameters) -> HalfRod:
        """This state as one of the problem with other parameters (f_gamma, W, stay the state's)."""
        return replace(self, parameters=parameters)

    def set_scalar(self, column: int, value: float) -> HalfRod:
        """This state with one of the kept scalars (``closure.SIGMA``...) replaced."""
        scalars = self.scalars.copy()
        scalars[column - col.CX] = value
        return replace(self, scalars=scalars)


@dataclass(frozen=True)
class Increment:
    """A change of state: a Newton step or a derivative along a path."""

    nodes: np.ndarray
    stages: np.ndarray
    scalars: np.ndarray

    @property
    def size(self) -> float:
        """Largest change of any node component or scalar."""
        return float(max(np.abs(self.nodes).max(), np.abs(self.scalars).max()))
