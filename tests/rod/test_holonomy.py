"""Holonomy of a curve whose tangent is known, on finer and finer edges."""

from __future__ import annotations

import numpy as np
from scipy.integrate import quad

from derod.rod import arrays, assembly
from derod.rod.mesh import dry_mesh
from derod.rod.physics import constants


def tangent(s: float) -> np.ndarray:
    """A tangent that leaves e_z and comes back while it turns about it by 5 rad."""
    tilt, turn = 1.2 * np.sin(np.pi * s) ** 2, 5 * s
    return np.array([np.sin(tilt) * np.cos(turn), np.sin(tilt) * np.sin(turn), np.cos(tilt)])


def error(edges: int) -> float:
    """Error of psi against the solid angle int (1 - cos tilt) dturn."""
    physics = constants(3, 1.0, drop=False, twisting=0.9)
    mesh = dry_mesh(edges)
    room = arrays.new_room(mesh, physics)
    q = np.zeros((edges + 1, 4))
    ends = np.linspace(0, 1, edges + 1)
    for i in range(1, edges + 1):
        for k in range(3):
            step = quad(lambda s, k=k: tangent(s)[k], ends[i - 1], ends[i])[0]
            q[i, k] = q[i - 1, k] + step
    exact = quad(lambda s: 5 * (1 - np.cos(1.2 * np.sin(np.pi * s) ** 2)), 0, 1)[0]
    psi, _ = assembly.gradient(physics, mesh, q, np.zeros(8), exact, room)
    return abs(psi - exact)


def test_fourth_order() -> None:
    coarse, fine = error(20), error(40)
    assert fine < 2e-4
    assert np.log2(coarse / fine) > 3.7
