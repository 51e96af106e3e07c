"""The clamped-clamped planar elastica: its closed form, and our rod on it."""

from __future__ import annotations

import numpy as np
from scipy.optimize import brentq
from scipy.special import ellipe, ellipk

import derod
from derod.record import BaseRun

SHORTENING = 0.2  # L

SCENE = """
[rod]
length = 1
bending = 1
twisting = 1
[push]
start = 0.01
stop = {stop}
max_step = 0.1
[mesh]
edges = {edges}
[model]
dimension = 2
drop = false
"""


def elastica_scene(edges: int) -> derod.Scene:
    """Return the scene, to be pushed to an end-shortening of 0.2 L."""
    return derod.parse_scene(SCENE.format(edges=edges, stop=SHORTENING))


def exact_elastica() -> tuple[float, float]:
    """Return the load P L^2/K and the mid-height (L) at an end-shortening of 0.2 L.

    Four quarter arcs: delta = 2 (1 - E/K), P = 16 K^2, height = sqrt(m)/K of the parameter m.
    """
    m = brentq(lambda m: 2 * (1 - ellipe(m) / ellipk(m)) - SHORTENING, 1e-9, 0.9)
    return 16 * ellipk(m) ** 2, np.sqrt(m) / ellipk(m)


def elastica_errors(run: BaseRun) -> dict[str, float]:
    """Return the errors of the last state: of the load, relative, and of the mid-height, L."""
    load, height = exact_elastica()
    found = abs(run.positions(-1)[:, 1]).max()
    return {
        "tension_error": abs(-run.table["end_tension"][-1] / load - 1),
        "shape_error": abs(found - height),
    }
