"""A branch as a table: numbers, node states and meshes of its points, and what they look like."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from derod.branches.half_rod.center_line import half_curve
from derod.branches.half_rod.gauss import STAGES
from derod.branches.half_rod.parameters import Parameters
from derod.branches.half_rod.recover import stage_guess
from derod.branches.half_rod.state import HalfRod


@dataclass(eq=False)
class Tabulated:
    """One branch. ``table``: structured array, one row a point (``files.layout.POINT``, in D and K0).
    ``bifurcations``: its special points (BIFURCATION). ``mirror``: the name of its class.
    ``all_nodes`` (k, 10), ``all_eta`` (k,): node states and element lengths of all points, one after
    another.
    """

    name: str
    parameters: Parameters
    table: np.ndarray
    bifurcations: np.ndarray
    mirror: str
    all_nodes: np.ndarray
    all_eta: np.ndarray

    @cached_property
    def _start(self) -> np.ndarray:
        counts = self.table["elements"].astype(np.int64)
        return np.concatenate([[0], np.cumsum(counts)])

    def __len__(self) -> int:
        return len(self.table)

    def state(self, i: int) -> HalfRod:
        """The half-rod state of point i; its stages are interpolated (settle it before reading t
        or E off it)."""
        i = range(len(self))[i]
        row = self.table[i]
        first, last = self._start[i], self._start[i + 1]
        eta = self.all_eta[first:last]
        nodes = self.all_nodes[first + 2 * i : last + 2 * (i + 1)]
        state = HalfRod(
            self.parameters,
            eta,
            int(row["inner"]),
            nodes,
            np.empty((eta.size, STAGES, 4)),
            np.append(row["scalars"], self.parameters.weight),
        )
        state.stages[:] = stage_guess(state)
        return state

    def half_rod(self, i: int, subdivisions: int = 3) -> tuple[np.ndarray, np.ndarray]:
        """Arc length (k,) from the middle and places w = r - r_C (k, 3) of half a rod, D."""
        return half_curve(self.state(i), subdivisions)

    def arc_length(self, i: int) -> np.ndarray:
        """Arc length (2k-1,) of ``positions(i)`` from the first clamp, D."""
        s, _ = self.half_rod(i)
        half = 0.5 * self.parameters.length
        return np.concatenate([half - s[::-1], half + s[1:]])

    def positions(self, i: int) -> np.ndarray:
        """Centre line (2k-1, 3) from the clamp at the origin to (0, 0, l - delta), D.

        The second half is computed, the first is its image under the half turn about e_y.
        """
        _, w = self.half_rod(i)
        r = w + np.array([0.0, self.table[i]["drop_y"], 0.0])
        image = r[::-1] * np.array([-1.0, 1.0, -1.0])
        r = np.vstack([image, r[1:]])
        r[:, 2] += 0.5 * (self.parameters.length - self.table[i]["end_shortening"])
        return r

    def drop_center(self, i: int) -> np.ndarray:
        """Centre of the drop (3,) in the frame of ``positions``, D."""
        row = self.table[i]
        return np.array(
            [0.0, row["drop_y"], 0.5 * (self.parameters.length - row["end_shortening"])]
        )
