"""A state's stages, guessed from its nodes: files hold no stages."""

from __future__ import annotations

import numpy as np

from derod.branches.half_rod.element import moment, quaternion_rate, tangent
from derod.branches.half_rod.gauss import NODES
from derod.branches.half_rod.section import add_section_rate, local_twist
from derod.branches.half_rod.state import HalfRod


def stage_guess(state: HalfRod) -> np.ndarray:
    """Stage quaternions by cubic Hermite interpolation of the node quaternions."""
    prm = state.parameters
    twist = (1.0 - prm.twisting) * state.scalars[2]
    rates = np.empty((len(state.nodes), 4))
    m, t = np.empty(3), np.empty(3)
    for y, rate in zip(state.nodes, rates, strict=True):
        moment(state.scalars[0], state.scalars[1], y[0:3], y[7:10], m)
        if prm.anisotropic:
            tangent(y[3:7], t)
            twist = local_twist(m, prm.section, t)
        quaternion_rate(m, twist, y[3:7], rate)
        if prm.anisotropic:
            add_section_rate(m, prm.section, y[3:7], rate)
    left = np.arange(state.eta.size) + (np.arange(state.eta.size) >= state.inner)
    h = state.lengths[:, None, None]
    a, b = state.nodes[left, None, 3:7], state.nodes[left + 1, None, 3:7]
    da, db = rates[left, None], rates[left + 1, None]
    x = NODES[None, :, None]
    out = (1 + 2 * x) * (1 - x) ** 2 * a + x * x * (3 - 2 * x) * b
    out += h * x * (1 - x) * ((1 - x) * da - x * db)
    return np.asarray(out)
