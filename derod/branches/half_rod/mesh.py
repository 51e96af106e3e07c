"""Meshes that follow a state: how fast things vary along the rod, and moving a state to a new
mesh."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from derod.branches.half_rod.fields import Fields, evaluate_fields, interpolate, section_fields
from derod.branches.half_rod.gauss import NODES, STAGES
from derod.branches.half_rod.outcome import NotConverged
from derod.branches.half_rod.state import HalfRod

RESOLUTION = 1.35
"""Elements per natural length of the local linearised rod."""
CONE = 1.0
"""Weight of 1/r, times v0^(1/10): an element of length h sees a share (h/r)^10 of the kink v0."""
POLE = 1.0
"""Weight of |dr/ds|/gap beside 1/r: near the meniscus v(s) has a pole gap/2 further out."""
GRADING = 0.35
"""Largest change of the target element length per unit of arc length (in element lengths)."""
DRIFT = 1.35
"""A mesh is replaced when an element holds this much more than the mean of the density's
integral."""
LEAST_ELEMENTS = 8
MOST_ELEMENTS = 4000
"""On each of the two intervals; only a state outside its wall layer's reach asks for more."""


def density(state: HalfRod, fields: Fields) -> np.ndarray:
    """Inverse natural length at the Gauss points (E, m): turning, tension |n|^(1/2), wall
    stiffness (d^2v/dr^2)^(1/4), the wall's cone 1/r and its pole; outside the drop it decays with
    the boundary layer. Raises NotConverged for a state outside the wall."""
    prm = state.parameters
    turning = _turning(state, fields)
    tension = np.sqrt(np.linalg.norm(fields.forces, axis=2))
    radius = np.linalg.norm(fields.places, axis=2)
    out = 1.0 + turning + tension
    wet = slice(None, state.inner)
    gap = 1.0 + prm.wall_softness - 2.0 * radius[wet]
    if not gap.min() > 0.0:
        raise NotConverged("a Gauss point lies outside the wall")
    crossing = np.abs(np.einsum("eki,eki->ek", fields.places, fields.tangents)[wet]) / radius[wet]
    kink = 1.0 / (radius[wet] + 1e-3) + POLE * crossing / gap
    out[wet] += (8.0 * prm.wall_strength / gap**3) ** 0.25
    out[wet] += CONE * prm.wall_strength**0.1 * kink
    s = state.node_arc_length
    left = s[:-1][np.arange(s.size - 1) != state.inner]
    points = left[:, None] + state.lengths[:, None] * NODES
    layer = np.exp(-0.15 * tension[-1, -1] * (points - state.sigma))
    dry = slice(state.inner, None)
    out[dry] = 0.5 + (turning[dry] + tension[dry]) * np.maximum(layer[dry], 0.1)
    return out


def _turning(state: HalfRod, fields: Fields) -> np.ndarray:
    """|m| where K1 = K2; else |u|, or the rate of gyration of small rotations, mu_i/(k_j k_k)^(1/2)."""
    if not state.parameters.anisotropic:
        return np.asarray(np.linalg.norm(fields.moments, axis=2))
    strains, first = section_fields(state, fields)
    k3, k1, k2 = state.parameters.section
    m, t = fields.moments, fields.tangents
    along = [np.sum(m * d, axis=2) for d in (first, np.cross(t, first), t)]
    rates = [x / np.sqrt(k) for x, k in zip(along, (k2 * k3, k1 * k3, k1 * k2), strict=True)]
    return np.maximum(np.linalg.norm(strains, axis=2), np.linalg.norm(rates, axis=0))


def _graded(points: np.ndarray, values: np.ndarray) -> np.ndarray:
    """The least density above ``values`` whose inverse changes by at most GRADING per unit
    length."""
    h = 1.0 / values
    slope = GRADING * points
    forward = slope + np.minimum.accumulate(h - slope)
    backward = np.minimum.accumulate((h + slope)[::-1])[::-1] - slope
    return 1.0 / np.minimum(forward, backward)


def _interval(
    points: np.ndarray, values: np.ndarray, length: float
) -> tuple[np.ndarray, np.ndarray]:
    """Knots on [0, length] and the graded density's integral up to them."""
    graded = _graded(points, values)
    knots = np.concatenate([[0.0], points, [length]])
    heights = np.concatenate([graded[:1], graded, graded[-1:]])
    area = np.concatenate([[0.0], np.cumsum(0.5 * np.diff(knots) * (heights[1:] + heights[:-1]))])
    return knots, area


def _halves(state: HalfRod) -> list[tuple[np.ndarray, np.ndarray, np.ndarray, float]]:
    """For the inner and the outer interval: knots, integrated density, element ends, length."""
    values = density(state, evaluate_fields(state))
    out = []
    outer = 0.5 * state.parameters.length - state.sigma
    for part, length in (
        (slice(None, state.inner), state.sigma),
        (slice(state.inner, None), outer),
    ):
        ends = np.concatenate([[0.0], np.cumsum(state.eta[part])]) * length
        points = (ends[:-1, None] + np.diff(ends)[:, None] * NODES).ravel()
        knots, area = _interval(points, values[part].ravel(), length)
        out.append((knots, area, ends, length))
    return out


def drifted(state: HalfRod, resolution: float = RESOLUTION) -> bool:
    """Whether the state has outgrown its mesh."""
    for knots, area, ends, _ in _halves(state):
        share = np.diff(np.interp(ends, knots, area)).max()
        if share * resolution > DRIFT:
            return True
    return False


def adapted(state: HalfRod, resolution: float = RESOLUTION) -> HalfRod:
    """The state on a mesh that equidistributes the density, ``resolution`` elements per unit of
    it. Raises NotConverged where the density asks for more than MOST_ELEMENTS."""
    etas = []
    for knots, area, _, length in _halves(state):
        wanted = area[-1] * resolution
        if not wanted <= MOST_ELEMENTS:
            raise NotConverged(f"the wall layer asks for {wanted:.0f} elements")
        count = max(LEAST_ELEMENTS, int(np.ceil(wanted)))
        ends = np.interp(np.linspace(0.0, area[-1], count + 1), area, knots) / length
        ends[0], ends[-1] = 0.0, 1.0
        etas.append(np.diff(ends))
    return transferred(state, etas[0], etas[1])


def halved(state: HalfRod) -> HalfRod:
    """The state with every element cut in two."""
    eta = np.repeat(0.5 * state.eta, 2)
    return transferred(state, eta[: 2 * state.inner], eta[2 * state.inner :])


def transferred(state: HalfRod, inner_eta: np.ndarray, outer_eta: np.ndarray) -> HalfRod:
    """The state evaluated on another mesh (element lengths as fractions of the two intervals)."""
    fields = evaluate_fields(state)
    nodes, stages = [], []
    offset = 0
    for eta, part in ((inner_eta, state.eta[: state.inner]), (outer_eta, state.eta[state.inner :])):
        old = np.concatenate([[0.0], np.cumsum(part)])
        new = np.concatenate([[0.0], np.cumsum(eta)])
        points = np.concatenate([new[:-1], [1.0], (new[:-1, None] + eta[:, None] * NODES).ravel()])
        element = np.clip(np.searchsorted(old, points, side="right") - 1, 0, part.size - 1)
        at = (points - old[element]) / part[element]
        values = interpolate(state, fields, element + offset, at)
        nodes.append(values[: eta.size + 1])
        stages.append(values[eta.size + 1 :, 3:7].reshape(eta.size, STAGES, 4))
        offset += part.size
    return replace(
        state,
        eta=np.concatenate([inner_eta, outer_eta]),
        inner=inner_eta.size,
        nodes=np.concatenate(nodes),
        stages=np.concatenate(stages),
    )
