"""The centre line of a state, of half the rod by Hermite interpolation and of the whole rod anywhere."""

from __future__ import annotations

import numpy as np

from derod.branches.half_rod.element import moment, tangent
from derod.branches.half_rod.fields import evaluate_fields, interpolate
from derod.branches.half_rod.section import bending_strain
from derod.branches.half_rod.state import HalfRod


def half_curve(state: HalfRod, subdivisions: int = 3) -> tuple[np.ndarray, np.ndarray]:
    """Arc length (k,) from the middle and places w = r - r_C (k, 3) of half a rod, D.

    Between the nodes by quintic Hermite interpolation: the stages are not needed.
    """
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


def center_line(state: HalfRod, s: np.ndarray) -> np.ndarray:
    """Places (k, 3) of the whole rod at arc lengths ``s`` (k,) from the clamp at the origin, D."""
    half = 0.5 * state.parameters.length
    from_middle = np.asarray(s, dtype=float) - half
    nodes = np.delete(state.node_arc_length, state.inner + 1)
    distance = np.clip(np.abs(from_middle), 0.0, half)
    element = np.clip(np.searchsorted(nodes, distance, side="right") - 1, 0, state.eta.size - 1)
    at = (distance - nodes[element]) / state.lengths[element]
    r = interpolate(state, evaluate_fields(state), element, at)[:, :3]
    r[:, 1] -= state.nodes[-1, 1]
    r[from_middle < 0.0] *= np.array([-1.0, 1.0, -1.0])
    r[:, 2] += half - 0.5 * state.end_shortening
    return r


def _quintic(x: np.ndarray) -> tuple[np.ndarray, ...]:
    """Hermite weights at x in [0, 1] of value, slope, curvature at 0, then at 1."""
    y = 1.0 - x
    value = y**3 * (1.0 + 3.0 * x + 6.0 * x * x)
    slope = x * y**3 * (1.0 + 3.0 * x)
    bend = 0.5 * x * x * y**3
    mirrored = x**3 * (1.0 + 3.0 * y + 6.0 * y * y)
    return value, slope, bend, mirrored, -y * x**3 * (1.0 + 3.0 * y), 0.5 * y * y * x**3


def _directions(state: HalfRod) -> tuple[np.ndarray, np.ndarray]:
    """Tangents d_3 and their derivatives u x d_3 at the nodes, each (E+2, 3)."""
    slopes, bends = np.empty((len(state.nodes), 3)), np.empty((len(state.nodes), 3))
    m, u = np.empty(3), np.empty(3)
    for y, slope, bend in zip(state.nodes, slopes, bends, strict=True):
        tangent(y[3:7], slope)
        moment(state.scalars[0], state.scalars[1], y[0:3], y[7:10], m)
        bending_strain(m, state.parameters.section, y[3:7], u)
        bend[:] = np.cross(u, slope)
    return slopes, bends
