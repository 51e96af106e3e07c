"""Choose the arc-length grid: how many edges inside the drop, and how they are graded."""

from __future__ import annotations

import numpy as np

from derod.rod.arrays import Mesh
from derod.scene.program import legs
from derod.scene.tables import Mesh as MeshOptions
from derod.scene.tables import Scene


def wetted_mesh(options: MeshOptions, elastocapillary: float) -> Mesh:
    """Return the grid of a rod in a drop: a share of the edges wetted, the rest halved between the ends.

    The boundary layers beside the menisci are as wide as the elastocapillary length sqrt(K0/f_gamma), D.
    """
    edges = options.edges
    inside = round(options.wetted_share * edges)
    inside += (edges - inside) % 2
    place = (np.arange(inside) + 0.5) / inside
    weights = np.exp(options.inner_grading * np.sin(np.pi * place) ** 2)
    fractions = weights / weights.sum()
    return Mesh(
        (edges - inside) // 2, fractions, quadrature(fractions), options.layer * elastocapillary
    )


def mesh_of(scene: Scene) -> Mesh:
    """Return the grid of a scene; it does not change along a push."""
    if scene.drop is None:
        return dry_mesh(scene.mesh.edges)
    heavy = scene.drop.weight != 0 or any(leg.control == "weight" for leg in legs(scene))
    strongest = scene.drop.capillary_force / scene.rod.bending
    return wetted_mesh(scene.mesh, strongest**-0.5)._replace(clamp_layers=heavy)


def dry_mesh(edges: int) -> Mesh:
    """Return a uniform grid for a rod without a drop."""
    return Mesh(0, np.full(edges, 1 / edges), np.zeros(0), 1.0)


def quadrature(fractions: np.ndarray) -> np.ndarray:
    """Return weights, one a node, that integrate over [0, 1] divided into ``fractions``.

    Exact for cubics: every interval integrates the cubic through its four nearest nodes (Gregory's
    rule where the fractions are equal). Mirror-symmetric fractions get mirror-symmetric weights.
    """
    n = fractions.size
    nodes = np.concatenate(([0.0], np.cumsum(fractions)))
    first = np.clip(np.arange(n) - 1, 0, n - 3)[:, None] + np.arange(4)  # the nodes of each cubic
    local = (nodes[first] - nodes[:-1, None]) / fractions[:, None]  # the interval is [0, 1]
    powers = local[:, None, :] ** np.arange(4)[:, None]
    moments = np.broadcast_to(1 / np.arange(1.0, 5.0)[:, None], (n, 4, 1))
    shares = np.linalg.solve(powers, moments)[:, :, 0] * fractions[:, None]
    weights = np.zeros(n + 1)
    np.add.at(weights, first, shares)
    return 0.5 * (weights + weights[::-1])
