"""A branch read from a file: its table, its states, its centre lines, and landings on it."""

from __future__ import annotations

from typing import TYPE_CHECKING

import h5py
import numpy as np

from derod.branches.half_rod.element import moment, quaternion_rate, tangent
from derod.branches.half_rod.gauss import NODES, STAGES
from derod.branches.half_rod.parameters import Parameters
from derod.branches.half_rod.state import HalfRod

if TYPE_CHECKING:
    from derod.branches.paths.landing import Landing


class StoredBranch:
    """One branch of a file. ``table``: structured array (POINT). ``bifurcations``:
    (BIFURCATION)."""

    def __init__(self, name: str, group: h5py.Group, parameters: Parameters) -> None:
        self.name = name
        self.parameters = parameters
        self.table: np.ndarray = group["table"][:]
        self.bifurcations: np.ndarray = group["bifurcations"][:]
        self.begins = str(group.attrs["begins"])
        self.ends = str(group.attrs["ends"])
        self.remarks = str(group.attrs["remarks"]).splitlines()
        self.mirror = str(group.attrs["mirror"])
        self._nodes = group["nodes"][:]
        self._eta = group["eta"][:]
        counts = self.table["elements"].astype(np.int64)
        self._start = np.concatenate([[0], np.cumsum(counts)])

    def __len__(self) -> int:
        return len(self.table)

    def at(self, end_shortening: float) -> tuple[Landing, ...]:
        """The branch's states at an end-shortening (D), solved there, on all its sheets.

        In the order of the branch's points; values in D and K0. Raises LandingError where the
        branch has no state there, or one cannot be solved.
        """
        from derod.branches.paths.landing import states_at

        return states_at(self, float(end_shortening))

    def solved(self, i: int) -> HalfRod:
        """The state of point i, solved again from what is stored. Raises NotConverged."""
        from derod.branches.paths.interval import solved

        return solved(self, range(len(self))[i]).state

    def state(self, i: int) -> HalfRod:
        """The half-rod state of point i; its stages are interpolated (settle it before reading t
        or E off it)."""
        i = range(len(self))[i]
        row = self.table[i]
        first, last = self._start[i], self._start[i + 1]
        eta = self._eta[first:last]
        nodes = self._nodes[first + 2 * i : last + 2 * (i + 1)]
        state = HalfRod(
            self.parameters,
            eta,
            int(row["inner"]),
            nodes,
            np.empty((eta.size, STAGES, 4)),
            np.append(row["scalars"], self.parameters.weight),
        )
        state.stages[:] = _stage_guess(state)
        return state

    def half_rod(self, i: int, subdivisions: int = 3) -> tuple[np.ndarray, np.ndarray]:
        """Arc length (k,) from the middle and places w = r - r_C (k, 3) of half a rod, D."""
        state = self.state(i)
        left = np.arange(state.eta.size) + (np.arange(state.eta.size) >= state.inner)
        places = state.nodes[:, :3]
        slopes, bends = _directions(state)
        x = (np.arange(subdivisions) / subdivisions)[None, :, None]
        h = state.lengths[:, None, None]
        value, rate, curvature = places[:, None], slopes[:, None], bends[:, None]
        a, b, c, d, e, f = _quintic(x)
        curve = a * value[left] + h * b * rate[left] + h * h * c * curvature[left]
        right = left + 1
        curve += d * value[right] + h * e * rate[right] + h * h * f * curvature[right]
        nodes = np.delete(state.node_arc_length, state.inner + 1)
        s = nodes[:-1, None] + state.lengths[:, None] * x[0, :, 0]
        return np.append(s, nodes[-1]), np.vstack([curve.reshape(-1, 3), places[-1]])

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


def _quintic(x: np.ndarray) -> tuple[np.ndarray, ...]:
    """Hermite weights at x in [0, 1] of value, slope, curvature at 0, then at 1."""
    y = 1.0 - x
    value = y**3 * (1.0 + 3.0 * x + 6.0 * x * x)
    slope = x * y**3 * (1.0 + 3.0 * x)
    bend = 0.5 * x * x * y**3
    mirrored = x**3 * (1.0 + 3.0 * y + 6.0 * y * y)
    return value, slope, bend, mirrored, -y * x**3 * (1.0 + 3.0 * y), 0.5 * y * y * x**3


def _directions(state: HalfRod) -> tuple[np.ndarray, np.ndarray]:
    """Tangents d_3 and their derivatives m x d_3 at the nodes, each (E+2, 3)."""
    slopes, bends, m = np.empty((len(state.nodes), 3)), np.empty((len(state.nodes), 3)), np.empty(3)
    for y, slope, bend in zip(state.nodes, slopes, bends, strict=True):
        tangent(y[3:7], slope)
        moment(state.scalars[0], state.scalars[1], y[0:3], y[7:10], m)
        bend[:] = np.cross(m, slope)
    return slopes, bends


def _stage_guess(state: HalfRod) -> np.ndarray:
    """Stage quaternions by cubic Hermite interpolation of the node quaternions."""
    prm = state.parameters
    twist = (1.0 - prm.twisting) * state.scalars[2]
    rates = np.empty((len(state.nodes), 4))
    m = np.empty(3)
    for y, rate in zip(state.nodes, rates, strict=True):
        moment(state.scalars[0], state.scalars[1], y[0:3], y[7:10], m)
        quaternion_rate(m, twist, y[3:7], rate)
    left = np.arange(state.eta.size) + (np.arange(state.eta.size) >= state.inner)
    h = state.lengths[:, None, None]
    a, b = state.nodes[left, None, 3:7], state.nodes[left + 1, None, 3:7]
    da, db = rates[left, None], rates[left + 1, None]
    x = NODES[None, :, None]
    out = (1 + 2 * x) * (1 - x) ** 2 * a + x * x * (3 - 2 * x) * b
    out += h * x * (1 - x) * ((1 - x) * da - x * db)
    return np.asarray(out)
