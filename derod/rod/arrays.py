"""The arrays kernels work in, made once a mesh.

Terms that depend on edges are differentiated by edges and turned into node form once, in ``assembly``.
Edge e runs from node e-1 to node e and its tension is q[e, d], e = 1 ... N. The clamps' tangents stand in
for the edges 0 and N+1, of rest length 0; vertex i joins the edges i and i+1. Arrays "by edge" have N+2
entries, "by vertex" N+1. What the gradient reads has a row for every component, and its loops fill one
array each, so that they run on several edges at once.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from derod.rod.frames import Frames, new_frames
from derod.rod.unknowns import ANGLE, BORDER, CARRIED, border_count, half_width


class Mesh(NamedTuple):
    """The arc-length grid: N edges in three regions, [0, s_A], [s_A, s_B], [s_B, l] (``rod.grid``).

    Without a drop all edges are "inside", fractions of l, and there are no menisci.
    """

    outside: int  # edges in each outer region
    inside: np.ndarray  # fractions of the wetted length, one an inner edge
    quadrature: np.ndarray  # weights of an integral over the wetted part, one an inner node
    layer: float  # D, the length over which the outer edges stay short
    clamp_layers: bool = False  # whether they are short beside the clamps too

    @property
    def edges(self) -> int:
        """Return N."""
        return 2 * self.outside + self.inside.size


class Kinematics(NamedTuple):
    """What every term reads, computed once a state."""

    rest: np.ndarray  # (N+2,) rest lengths l, D
    slope: np.ndarray  # (2, N+2) dl/ds_A, dl/ds_B
    curve: np.ndarray  # (2, N+2) second derivatives; the mixed one is zero
    size: np.ndarray  # (N+2,) |e|, D
    inverse: np.ndarray  # (N+2,) 1/|e|
    tangent: np.ndarray  # (d, N+2) e / |e|
    change: np.ndarray  # (d, N+1) of the tangent at a vertex
    fall: np.ndarray  # (N+1,) 1 - cos phi of the turning angles
    weight: np.ndarray  # (N+1,) 1 / (l_i + l_{i+1})
    difference: np.ndarray  # (d, N+2) of the curvatures at an edge's ends
    along: np.ndarray  # (N+2,) t . (alpha t_+ + beta t_-), see ``defect``
    normal: np.ndarray  # (d, N+1) t_i x t_{i+1}, in three dimensions
    turn: np.ndarray  # (N+1,) phi^2
    turn_slope: np.ndarray  # (N+1,) d phi^2 / d(1 - cos phi)
    share: np.ndarray  # (N+1,) quadrature weights, of the wetted length; fixed
    barrier: np.ndarray  # (N+1,) the wall's stiffness against moving a node outward, K0/D^3
    node_a: int  # the menisci's nodes
    node_b: int
    frames: Frames | None  # of a section with directions of its own


class Gradient(NamedTuple):
    """First derivatives of the Lagrangian, in edge and node form."""

    direction: np.ndarray  # (d, N+2) by e/|e|, not yet made perpendicular to it
    edge: np.ndarray  # (d, N+2) by e
    node: np.ndarray  # (N+1, d) by x_i, what depends on x_i - x_C
    rest: np.ndarray  # (N+2,) by l, which takes it to s_A and s_B
    dual: np.ndarray  # (N+1,) by l_i + l_{i+1}
    constraint: np.ndarray  # (N+2,) by lambda: the stretch constraint g
    pull: np.ndarray  # (N+2,) force along the edge
    border: np.ndarray  # (BORDER+d,) by b
    holonomy: np.ndarray  # (d, N+2) of psi by e
    by_edge: np.ndarray  # (N+2,) room
    by_vertex: np.ndarray  # (N+1,) room


class Hessian(NamedTuple):
    """Second derivatives of the Lagrangian, in edge and node form; they work edge by edge."""

    tangent: np.ndarray  # (N+2, d) the tangents once more, a row an edge
    difference: np.ndarray  # (N+2, d) and the differences of curvature
    edge: np.ndarray  # (N+2, d, d) by e e; with angles (N+2, 4, 4), by (e, theta)
    vertex: np.ndarray  # (N+1, d, d) by e_i e_{i+1}, likewise
    skip: np.ndarray  # (N+2, d, d) by e_{i-1} e_{i+1}, likewise
    node: np.ndarray  # (N+1, d, d) by x_i x_i, what depends on x_i - x_C
    constraint: np.ndarray  # (N+2, 3, d) of g_e by e-1, e, e+1
    edge_menisci: np.ndarray  # (2, N+2, d) by e and s_A, s_B; with angles (2, N+2, 4)
    node_menisci: np.ndarray  # (2, N+1, d) by x_i and s_A, s_B, what is not in ``edge_menisci``
    constraint_menisci: np.ndarray  # (2, N+2) of g by s_A, s_B
    border: np.ndarray  # (BORDER+d, BORDER+d) by b b


class Linear(NamedTuple):
    """A bordered band matrix [[K, B], [B^T, C]]; row-major lower diagonals of K, padded below."""

    band: np.ndarray  # (wN + h, h+1) of half width h, band[j, k] = K[j+k, j]
    border: np.ndarray  # (wN + h, m)
    corner: np.ndarray  # (m, m)


class Room(NamedTuple):
    """Arrays the assembly works in, made once a mesh."""

    kin: Kinematics
    grad: Gradient
    hess: Hessian
    tension: np.ndarray  # (N+2,) by edge
    r: np.ndarray  # (N+1, w) residual by the unknowns of q
    rb: np.ndarray  # (d+5,) residual by b
    linear: Linear


def new_kinematics(mesh: Mesh, physics) -> Kinematics:
    """Return room for the kinematics of a mesh, the clamps' tangents filled in.

    Without a drop the menisci's nodes span an empty range.
    """
    d, n = len(physics.axis), mesh.edges + 2
    node_a, node_b = mesh.outside, mesh.outside + mesh.inside.size
    tangent = np.zeros((d, n))
    tangent[:, 0] = tangent[:, -1] = physics.axis
    share = np.zeros(n - 1)
    if physics.drop:
        share[node_a : node_b + 1] = mesh.quadrature
    return Kinematics(
        rest=np.zeros(n),
        slope=np.zeros((2, n)),
        curve=np.zeros((2, n)),
        size=np.ones(n),
        inverse=np.ones(n),
        tangent=tangent,
        change=np.zeros((d, n - 1)),
        fall=np.zeros(n - 1),
        weight=np.zeros(n - 1),
        difference=np.zeros((d, n)),
        along=np.zeros(n),
        normal=np.zeros((d, n - 1)),
        turn=np.zeros(n - 1),
        turn_slope=np.zeros(n - 1),
        share=share,
        barrier=np.zeros(n - 1),
        node_a=node_a if physics.drop else 1,
        node_b=node_b if physics.drop else 0,
        frames=new_frames(mesh.edges, physics.director_start, physics.director_end)
        if has_angles(physics)
        else None,
    )


def has_angles(physics) -> bool:
    """Return whether edges have angles, and frames."""
    return len(physics.row) > len(physics.axis) + 1


def new_q(edges: int, physics) -> np.ndarray:
    """Return zeros for a state's q; references lie along the clamp axis, their directors along e_x."""
    if not has_angles(physics):
        return np.zeros((edges + 1, len(physics.row)))
    q = np.zeros((edges + 1, len(physics.row) + CARRIED))
    q[:, ANGLE + 3] = q[:, ANGLE + 4] = 1.0
    return q


def new_gradient(edges: int, d: int) -> Gradient:
    """Return room for a gradient."""
    n = edges + 2
    return Gradient(
        direction=np.zeros((d, n)),
        edge=np.zeros((d, n)),
        node=np.zeros((edges + 1, d)),
        rest=np.zeros(n),
        dual=np.zeros(n - 1),
        constraint=np.zeros(n),
        pull=np.zeros(n),
        border=np.zeros(BORDER + d),
        holonomy=np.zeros((d, n)),
        by_edge=np.zeros(n),
        by_vertex=np.zeros(n - 1),
    )


def new_hessian(edges: int, d: int, by: int) -> Hessian:
    """Return room for a Hessian, of ``by`` numbers an edge: its components, and its angle if it has one."""
    n = edges + 2
    return Hessian(
        np.zeros((n, d)),
        np.zeros((n, d)),
        np.zeros((n, by, by)),
        np.zeros((edges + 1, by, by)),
        np.zeros((n, by, by)),
        np.zeros((edges + 1, d, d)),
        np.zeros((n, 3, d)),
        np.zeros((2, n, by)),
        np.zeros((2, edges + 1, d)),
        np.zeros((2, n)),
        np.zeros((BORDER + d, BORDER + d)),
    )


def new_linear(edges: int, physics) -> Linear:
    """Return room for a bordered band matrix."""
    d = len(physics.axis)
    half, m = half_width(d, angles=has_angles(physics)), border_count(d)
    rows = len(physics.row) * edges + half
    return Linear(np.zeros((rows, half + 1)), np.zeros((rows, m)), np.zeros((m, m)))


def new_room(mesh: Mesh, physics) -> Room:
    """Return room for assembling a mesh."""
    edges, d = mesh.edges, len(physics.axis)
    return Room(
        new_kinematics(mesh, physics),
        new_gradient(edges, d),
        new_hessian(edges, d, len(physics.row) - 1),
        np.zeros(edges + 2),
        np.zeros((edges + 1, len(physics.row))),
        np.zeros(BORDER + d),
        new_linear(edges, physics),
    )
