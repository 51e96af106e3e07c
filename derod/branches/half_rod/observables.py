"""Energies and other numbers of a settled half-rod state."""

from __future__ import annotations

import numpy as np

from derod.branches.half_rod.closure import jump
from derod.branches.half_rod.fields import bending_strains, evaluate_fields
from derod.branches.half_rod.gauss import WEIGHTS
from derod.branches.half_rod.state import HalfRod

SCALED = (
    "end_tension",
    "energy_hat",
    "energy_total",
    "energy_bend",
    "energy_twist",
    "energy_wall",
    "meniscus_force",
)
"""What is multiplied by K/K0, so that files and landings are in units of K0 as run files are."""


def observables(state: HalfRod) -> dict[str, float]:
    """End-shortening, tension, energies (K0/D), wetted length, meniscus force and drop_y of a
    state.

    Energies are of the whole rod. E_tot = bend + twist + wall - f_gamma (s_B - s_A) + W y_C,
    E_hat = E_tot + f_gamma (delta + 1); meniscus_force is f_B (eq:bcnd-end, toward the drop's
    centre); drop_y is y_C, measured from the clamp axis.
    """
    prm = state.parameters
    fields = evaluate_fields(state)
    weights = state.lengths[:, None] * WEIGHTS
    across = np.einsum("eki,eki->ek", fields.moments, fields.tangents)
    strains = bending_strains(state, fields)
    bend = float(np.sum(weights * (np.sum(fields.moments * strains, axis=2) - across**2)))
    u3 = state.scalars[2]
    twist = 0.5 * prm.length * prm.twisting * u3 * u3
    if prm.anisotropic:
        twist = float(np.sum(weights * across**2)) / prm.twisting
    wet = slice(None, state.inner)
    gap = 1.0 + prm.wall_softness - 2.0 * np.linalg.norm(fields.places[wet], axis=2)
    wall = 2.0 * float(np.sum(weights[wet] * prm.wall_strength / gap))
    capillary_force = float(state.scalars[5])
    drop_y = -float(state.nodes[-1, 1])
    total = bend + twist + wall - 2.0 * capillary_force * state.sigma + state.weight * drop_y
    delta = state.end_shortening
    after, jacobian = np.empty(10), np.empty((10, 11))
    force = jump(state.nodes[state.inner], capillary_force, prm.meniscus_wall, after, jacobian)
    return {
        "end_shortening": delta,
        "end_tension": state.end_tension,
        "energy_hat": total + capillary_force * (delta + 1.0),
        "energy_total": total,
        "energy_bend": bend,
        "energy_twist": float(twist),
        "energy_wall": wall,
        "wetted_length": 2.0 * state.sigma,
        "meniscus_force": float(force),
        "drop_y": drop_y,
        "wall_gap": fields.gap,
    }


def loops(state: HalfRod) -> float:
    """Turns of the tangent about e_x along the whole rod: 0 on Ax, j on L_j."""
    fields = evaluate_fields(state)
    weights = state.lengths[:, None] * WEIGHTS
    return float(abs(np.sum(weights * bending_strains(state, fields)[:, :, 0])) / np.pi)
