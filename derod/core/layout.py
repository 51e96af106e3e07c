"""How a state is laid out in arrays, and the constants a kernel needs.

State
    ``q``, shape (N+1, d+1): row i is node i's position x_i (d numbers, D) followed by the tension
    (K0/D^2) of the edge that ends there, lambda_{i-1}. Row 0 is the start clamp, its tension unused.
    ``b``, shape (d+5,): s_A, s_B, x_C (d), f_A, f_B and the slide force eta.
    d = 3, or 2 where the scene is planar; the clamp axis is the last coordinate.

Edge form
    Terms that depend on edges e_j = x_{j+1} - x_j are differentiated by edges and turned into node
    form once, in ``assembly``. Vertex i joins the edges i-1 and i; vertices 0 and N join an edge to
    the clamp's tangent.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

S_A, S_B, X_C = 0, 1, 2  # places in ``b``; f_A, f_B, eta follow the d numbers of x_C


class Physics(NamedTuple):
    """Dimensionless constants of a scene (eq:adim), with K0 = 1."""

    axis: tuple[float, ...]  # clamp tangent e_z; its length is the dimension d
    twisting: float  # k3
    capillary_force: float  # f_gamma
    wall_strength: float  # v0
    wall_softness: float  # rho
    length: float  # l


class Mesh(NamedTuple):
    """The arc-length grid: N edges in three regions, [0, s_A], [s_A, s_B], [s_B, l] (``core.grid``)."""

    outside: int  # edges in each outer region
    inside: np.ndarray  # fractions of the wetted length, one an inner edge
    layer: float  # D, the length over which the outer edges stay short

    @property
    def edges(self) -> int:
        """Return N."""
        return 2 * self.outside + self.inside.size


class Kinematics(NamedTuple):
    """What every term reads, computed once a state."""

    rest: np.ndarray  # (N,) rest lengths l_j, D
    slope: np.ndarray  # (2, N) dl_j/ds_A, dl_j/ds_B
    curve: np.ndarray  # (2, N) second derivatives; the mixed one is zero
    size: np.ndarray  # (N,) |e_j|, D
    tangent: np.ndarray  # (N, d) e_j / |e_j|
    node_a: int  # the menisci's nodes
    node_b: int


class Gradient(NamedTuple):
    """First derivatives of the Lagrangian, in edge and node form."""

    edge: np.ndarray  # (N, d) by e_j
    node: np.ndarray  # (N+1, d) by x_i, what is not in ``edge``
    rest: np.ndarray  # (N,) by l_j, which takes it to s_A and s_B
    constraint: np.ndarray  # (N,) by lambda_j: the stretch constraint g_j
    border: np.ndarray  # (d+5,) by b
    holonomy: np.ndarray  # (N, d) of psi by e_j


class Hessian(NamedTuple):
    """Second derivatives of the Lagrangian, in edge and node form."""

    edge: np.ndarray  # (N, d, d) by e_j e_j
    vertex: np.ndarray  # (N+1, d, d) by e_{i-1} e_i
    node: np.ndarray  # (N+1, d, d) by x_i x_i, what is not in ``edge``, ``vertex``
    constraint: np.ndarray  # (N, 3, d) of g_j by e_{j-1}, e_j, e_{j+1}
    edge_menisci: np.ndarray  # (2, N, d) by e_j and s_A, s_B
    node_menisci: np.ndarray  # (2, N+1, d) by x_i and s_A, s_B, what is not in ``edge_menisci``
    constraint_menisci: np.ndarray  # (2, N) of g_j by s_A, s_B
    border: np.ndarray  # (d+5, d+5) by b b


def new_kinematics(mesh: Mesh, d: int) -> Kinematics:
    """Return room for the kinematics of a mesh in ``d`` dimensions."""
    n = mesh.edges
    return Kinematics(
        np.zeros(n),
        np.zeros((2, n)),
        np.zeros((2, n)),
        np.zeros(n),
        np.zeros((n, d)),
        mesh.outside,
        mesh.outside + mesh.inside.size,
    )


def new_gradient(edges: int, d: int) -> Gradient:
    """Return room for a gradient."""
    return Gradient(
        np.zeros((edges, d)),
        np.zeros((edges + 1, d)),
        np.zeros(edges),
        np.zeros(edges),
        np.zeros(d + 5),
        np.zeros((edges, d)),
    )


def new_hessian(edges: int, d: int) -> Hessian:
    """Return room for a Hessian."""
    return Hessian(
        np.zeros((edges, d, d)),
        np.zeros((edges + 1, d, d)),
        np.zeros((edges + 1, d, d)),
        np.zeros((edges, 3, d)),
        np.zeros((2, edges, d)),
        np.zeros((2, edges + 1, d)),
        np.zeros((2, edges)),
        np.zeros((d + 5, d + 5)),
    )
