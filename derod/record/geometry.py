"""Frames, tubes and spheres to draw: arrays in, arrays out, many curves at once.

Curves are (..., N+1, 3) nodes, D, clamped along e_z at both ends. Leading axes are frames of a run.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

AXIS = np.array([0.0, 0.0, 1.0])


def unit(vectors: np.ndarray) -> np.ndarray:
    """Vectors (..., 3) over their lengths; null vectors stay null."""
    size = np.sqrt(np.einsum("...i,...i->...", vectors, vectors))[..., None]
    return np.divide(vectors, size, out=np.zeros_like(vectors), where=size > 0)


def edge_tangents(positions: np.ndarray) -> np.ndarray:
    """Unit tangents of the edges, (..., N, 3)."""
    return unit(np.diff(positions, axis=-2))


def tangents_with_clamps(positions: np.ndarray) -> np.ndarray:
    """Edge tangents with the clamps' e_z before and after them, (..., N+2, 3)."""
    inner = edge_tangents(positions)
    ends = np.broadcast_to(AXIS, (*inner.shape[:-2], 1, 3))
    return np.concatenate([ends, inner, ends], axis=-2)


def quaternion_product(p: np.ndarray, q: np.ndarray) -> np.ndarray:
    """The rotation q, then p, as quaternions (..., 4) with the scalar first."""
    pw, pv, qw, qv = p[..., :1], p[..., 1:], q[..., :1], q[..., 1:]
    w = pw * qw - np.sum(pv * qv, axis=-1, keepdims=True)
    return np.concatenate([w, pw * qv + qw * pv + np.cross(pv, qv)], axis=-1)


def rotate(q: np.ndarray, vector: np.ndarray) -> np.ndarray:
    """``vector`` (3,) turned by the unit quaternions q (..., 4)."""
    w, v = q[..., :1], q[..., 1:]
    across = 2 * np.cross(v, vector)
    return np.asarray(vector + w * across + np.cross(v, across))


def transports(positions: np.ndarray) -> np.ndarray:
    """Unit quaternions (..., N+1, 4) of parallel transport from the first clamp.

    Number j < N leads to edge j, the last to the end clamp; over each vertex the transport is the
    least rotation, (1 + a.b, a x b). Products over all lengths in log2 N passes.
    """
    tangents = tangents_with_clamps(positions)
    a, b = tangents[..., :-1, :], tangents[..., 1:, :]
    w = 1 + np.einsum("...i,...i->...", a, b)
    q = np.concatenate([w[..., None], np.cross(a, b)], axis=-1)
    size = np.linalg.norm(q, axis=-1, keepdims=True)
    q = np.where(size > 1e-12, q / np.maximum(size, 1e-12), [0.0, 1.0, 0.0, 0.0])
    shift = 1
    while shift < q.shape[-2]:
        later = quaternion_product(q[..., shift:, :], q[..., :-shift, :])
        q = np.concatenate([q[..., :shift, :], later], axis=-2)
        shift *= 2
    return q


class MaterialFrame(NamedTuple):
    """Unit vectors at the nodes, each (..., N+1, 3)."""

    d1: np.ndarray
    d2: np.ndarray
    d3: np.ndarray


def material_frame(
    positions: np.ndarray, arc_length: np.ndarray, twist: np.ndarray | float
) -> MaterialFrame:
    """The material frame at the nodes of an isotropic rod: e_x carried from the start clamp, turned by twist.

    ``arc_length`` (..., N+1), D; ``twist`` (...) is u3 = (R - psi)/l, the same all along, rad/D. The frame is
    the clamp's own at the first node, and the end clamp's, turned by R about the axis, at the last: the
    transport over the polygon of tangents misses (1/8) t_- . (t x t_+) at each edge
    (``derod.rod.terms.twist``), which psi has, and which is given back here edge by edge.
    """
    tangents = tangents_with_clamps(positions)
    before, own, after = tangents[..., :-2, :], tangents[..., 1:-1, :], tangents[..., 2:, :]
    corner = np.einsum("...i,...i->...", before, np.cross(own, after)) / 8
    start = np.zeros((*corner.shape[:-1], 1))
    missed = np.concatenate([start, np.cumsum(corner, axis=-1)], axis=-1)
    d3 = node_tangents(positions, arc_length)
    at_edges = rotate(transports(positions)[..., :-1, :], np.array([1.0, 0.0, 0.0]))
    first = np.broadcast_to(np.array([1.0, 0.0, 0.0]), (*at_edges.shape[:-2], 1, 3))
    bishop = np.concatenate([first, carried(at_edges, own, d3[..., 1:, :])], axis=-2)
    angle = (np.asarray(twist)[..., None] * arc_length + missed)[..., None]
    d1 = np.cos(angle) * bishop + np.sin(angle) * np.cross(d3, bishop)
    return MaterialFrame(d1, np.cross(d3, d1), d3)


def node_tangents(positions: np.ndarray, arc_length: np.ndarray) -> np.ndarray:
    """Unit tangents at the nodes, (..., N+1, 3): between those of the two edges, e_z at the clamps."""
    edges, lengths = edge_tangents(positions), np.diff(arc_length, axis=-1)[..., None]
    inner = lengths[..., 1:, :] * edges[..., :-1, :] + lengths[..., :-1, :] * edges[..., 1:, :]
    ends = np.broadcast_to(AXIS, (*edges.shape[:-2], 1, 3))
    return np.concatenate([ends, unit(inner), ends], axis=-2)


def carried(vectors: np.ndarray, a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Vectors (..., 3) across unit tangents a, turned by the least rotation that carries a to b."""
    along = np.einsum("...i,...i->...", vectors, b)[..., None]
    room = 1 + np.einsum("...i,...i->...", a, b)[..., None]
    return np.asarray(vectors - along / np.maximum(room, 1e-12) * (a + b))


def tube(
    positions: np.ndarray, frame: MaterialFrame, radius: float, sides: int
) -> tuple[np.ndarray, np.ndarray]:
    """Vertices and normals of a tube, each (..., (N+1) sides, 3), ring after ring from d1 on."""
    around = 2 * np.pi * np.arange(sides) / sides
    cos, sin = np.cos(around)[:, None], np.sin(around)[:, None]
    normals = cos * frame.d1[..., None, :] + sin * frame.d2[..., None, :]
    vertices = positions[..., None, :] + radius * normals
    shape = (*positions.shape[:-2], positions.shape[-2] * sides, 3)
    return vertices.reshape(shape), normals.reshape(shape)


def tube_triangles(nodes: int, sides: int) -> np.ndarray:
    """Vertex numbers of the triangles of such a tube, (2 (nodes - 1) sides, 3)."""
    ring, side = np.meshgrid(np.arange(nodes - 1), np.arange(sides), indexing="ij")
    here = (ring * sides + side).ravel()
    beside = (ring * sides + (side + 1) % sides).ravel()
    pair = [[here, beside, here + sides], [beside, beside + sides, here + sides]]
    return np.concatenate([np.stack(corner, axis=-1) for corner in pair]).astype(np.uint32)


def sphere(radius: float, rings: int = 32, sides: int = 64) -> tuple[np.ndarray, np.ndarray]:
    """Vertices ((rings + 1) sides, 3) and triangles of a sphere about the origin."""
    polar = np.pi * np.arange(rings + 1) / rings
    around = 2 * np.pi * np.arange(sides) / sides
    theta, phi = np.meshgrid(polar, around, indexing="ij")
    vertices = radius * np.stack(
        [np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)], axis=-1
    )
    return vertices.reshape(-1, 3), tube_triangles(rings + 1, sides)


def point_at(positions: np.ndarray, arc_length: np.ndarray, s: float) -> np.ndarray:
    """The point (3,) at arc length ``s`` of one curve (N+1, 3)."""
    return np.array([np.interp(s, arc_length, positions[:, k]) for k in range(3)])
