"""Frames and moments of a recorded section with directions, from the frames of its edges."""

from __future__ import annotations

import numpy as np

from derod.record.geometry import MaterialFrame, carried, tangents_with_clamps, unit
from derod.scene import Scene


def edge_directors(positions: np.ndarray, edge_frame: np.ndarray, scene: Scene) -> np.ndarray:
    """Return frames [d_1, d_2, d_3] of the clamp, the N edges and the other clamp, (N+2, 3, 3).

    ``edge_frame`` (N, 7) holds angles and what they are counted from (``derod.pushing.frames``): the
    reference director, carried to the present tangent by the least rotation, is turned by the angle.
    """
    tangents = tangents_with_clamps(positions)
    t, before, director = tangents[1:-1], edge_frame[:, 1:4], edge_frame[:, 4:]
    reference, angle = carried(director, before, t), edge_frame[:, :1]
    first = np.zeros_like(tangents)
    first[1:-1] = np.cos(angle) * reference + np.sin(angle) * np.cross(t, reference)
    start, end = scene.clamps.directors or (0.0, scene.clamps.end_rotation)
    first[0], first[-1] = (np.cos(start), np.sin(start), 0), (np.cos(end), np.sin(end), 0)
    return np.stack([first, np.cross(tangents, first), tangents], axis=1)


def section_frame(
    positions: np.ndarray, arc_length: np.ndarray, edge_frame: np.ndarray, scene: Scene
) -> MaterialFrame:
    """Return the material frame at the nodes: between those of the edges that meet there."""
    frames = edge_directors(positions, edge_frame, scene)
    rest = np.concatenate([[0.0], np.diff(arc_length), [0.0]])
    share = (rest[:-1] / (rest[:-1] + rest[1:]))[:, None]
    middle = (1 - share[:, :, None]) * frames[:-1] + share[:, :, None] * frames[1:]
    d3 = unit(middle[:, 2])
    d1 = unit(middle[:, 0] - np.sum(middle[:, 0] * d3, axis=1, keepdims=True) * d3)
    return MaterialFrame(d1, np.cross(d3, d1), d3)


def section_moment(
    positions: np.ndarray, arc_length: np.ndarray, edge_frame: np.ndarray, scene: Scene
) -> np.ndarray:
    """Return K_1 (u_1 - k_1) d_1 + K_2 (u_2 - k_2) d_2 + K_3 (u_3 - tau_0) d_3 at the nodes, (N+1, 3), K0/D.

    Of second order in the edge length.
    """
    frames = edge_directors(positions, edge_frame, scene)
    turn = np.einsum("nik,njk->nij", frames[:-1], frames[1:])  # the later frame in the earlier one
    skew = np.stack(
        [
            turn[:, 2, 1] - turn[:, 1, 2],
            turn[:, 0, 2] - turn[:, 2, 0],
            turn[:, 1, 0] - turn[:, 0, 1],
        ],
        axis=1,
    )
    cosine = np.clip(turn[:, 2, 2], -1, 1)
    phi = np.arccos(cosine)
    bent = np.where(phi > 1e-6, phi / np.maximum(np.sin(phi), 1e-300), 1.0)
    strain = 0.5 * bent[:, None] * skew
    strain[:, 2] = np.arctan2(skew[:, 2], turn[:, 0, 0] + turn[:, 1, 1])
    rest = np.concatenate([[0.0], np.diff(arc_length), [0.0]])
    rates = strain / (0.5 * (rest[:-1] + rest[1:]))[:, None]
    rod = scene.rod
    natural = np.array([*(rod.natural_curvature or (0.0, 0.0)), rod.natural_twist or 0.0])
    stiffness = np.array([rod.bending, rod.bending_2 or rod.bending, rod.twisting])
    nodes = section_frame(positions, arc_length, edge_frame, scene)
    return np.einsum("nj,njk->nk", stiffness * (rates - natural), np.stack(nodes, axis=1))
