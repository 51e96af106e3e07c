"""Material frames of a rod whose section has directions of its own, and the strains between them.

An edge's frame is d_3 = e/|e| and the directors d_1, d_2 of its section. The state holds one angle an edge,
counted from a reference director that is carried along in time (time-parallel, Bergou et al. 2010): from its
own tangent to the present one by the least rotation. The reference belongs to the state, behind its unknowns
(``rod.unknowns``); ``renew`` makes the present frame without its angle the new reference, which changes
no frame and makes derivatives local.

With the rotation Q from one frame to the next, in the frame's own axes, a vertex has three strains

    v_1, v_2 = F (Q_32 - Q_23, Q_13 - Q_31) / 2,   v_3 = atan2(Q_21 - Q_12, Q_11 + Q_22)

F = phi/sin(phi) of the turning angle: the curvature binormal's components along d_1 and d_2, averaged over
both frames (Bergou et al. 2008, with phi for their 2 tan(phi/2)), and the angle of twist. No branch needs
to be remembered: links are followed, since a vertex is never twisted by pi.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from derod.algebra.jit import inlined, kernel
from derod.rod.angle import over_sine
from derod.rod.unknowns import ANGLE, REFERENCE


class Frames(NamedTuple):
    """Frames, strains, and what terms derive by them. Kernels of an isotropic rod have None in its place."""

    first: np.ndarray  # (3, N+2) d_1 of every edge, the clamps' among them
    second: np.ndarray  # (3, N+2) d_2
    strain: np.ndarray  # (3, N+1) v of every vertex
    slope: np.ndarray  # (N+1, 3, 6) dv by the body rotations of the left and the right frame
    by_strain: np.ndarray  # (3, N+1) derivatives by v
    moment: np.ndarray  # (N+2, 3) derivatives by the frames' body rotations, K/D
    own: np.ndarray  # (N+1, 3, 3) second derivatives by the strains of a vertex
    next: np.ndarray  # (N+2, 3, 3) by those of the vertices before and behind an edge
    menisci: np.ndarray  # (2, N+1, 3) by strains and s_A, s_B
    by_edges: np.ndarray  # (N+1, 3, 8) dv by both edges and their angles
    relative: np.ndarray  # (3, 3) room: Q
    rows: np.ndarray  # (5, 6) room: derivatives of what v is made of
    weights: np.ndarray  # (3, 3) room
    curve: np.ndarray  # (6, 6) room: second derivatives by body rotations
    turns: np.ndarray  # (6, 8) room: body rotations by edges and angles
    block: np.ndarray  # (8, 8) room
    slopes: np.ndarray  # (7,) room of ``terms.strains``
    curves: np.ndarray  # (7, 7)


def new_frames(edges: int, start: float, end: float) -> Frames:
    """Return room for frames; ``start`` and ``end`` are the clamps' directors' angles from e_x, radians."""
    n = edges + 2
    first, second = np.zeros((3, n)), np.zeros((3, n))
    for e, angle in ((0, start), (-1, end)):
        cosine, sine = exact_turn(angle)
        first[:, e] = cosine, sine, 0.0
        second[:, e] = -sine, cosine, 0.0
    return Frames(
        first,
        second,
        np.zeros((3, n - 1)),
        np.zeros((n - 1, 3, 6)),
        np.zeros((3, n - 1)),
        np.zeros((n, 3)),
        np.zeros((n - 1, 3, 3)),
        np.zeros((n, 3, 3)),
        np.zeros((2, n - 1, 3)),
        np.zeros((n - 1, 3, 8)),
        np.zeros((3, 3)),
        np.zeros((5, 6)),
        np.zeros((3, 3)),
        np.zeros((6, 6)),
        np.zeros((6, 8)),
        np.zeros((8, 8)),
        np.zeros(7),
        np.zeros((7, 7)),
    )


def exact_turn(angle: float) -> tuple[float, float]:
    """Return cosine and sine of an angle, exact at quarter turns: a planar rod stays exactly planar."""
    quarters = angle / (0.5 * math.pi)
    if quarters == round(quarters):
        return ((1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0))[round(quarters) % 4]
    return math.cos(angle), math.sin(angle)


@kernel
def measure_frames(q, kin, frames):
    """Fill frames, strains and their slopes for the state whose tangents are in ``kin``."""
    if frames is None:
        return
    for e in range(1, q.shape[0]):
        present_frame(q, kin.tangent, e, frames)
    for i in range(q.shape[0]):
        fill_relative(kin.tangent, i, frames)
        fill_strain(kin.fall[i], i, frames)


@inlined
def present_frame(q, tangent, e, frames):
    """Fill the frame of one edge: its reference carried to its tangent, then turned by its angle."""
    along, cosine = 0.0, 0.0
    for k in range(3):
        along += q[e, REFERENCE + 3 + k] * tangent[k, e]
        cosine += q[e, REFERENCE + k] * tangent[k, e]
    along /= 1 + cosine
    c, s = math.cos(q[e, ANGLE]), math.sin(q[e, ANGLE])
    x = q[e, REFERENCE + 3] - along * (q[e, REFERENCE] + tangent[0, e])
    y = q[e, REFERENCE + 4] - along * (q[e, REFERENCE + 1] + tangent[1, e])
    z = q[e, REFERENCE + 5] - along * (q[e, REFERENCE + 2] + tangent[2, e])
    tx, ty, tz = tangent[0, e], tangent[1, e], tangent[2, e]
    u, v, w = ty * z - tz * y, tz * x - tx * z, tx * y - ty * x
    frames.first[0, e], frames.first[1, e] = c * x + s * u, c * y + s * v
    frames.first[2, e] = c * z + s * w
    frames.second[0, e], frames.second[1, e] = c * u - s * x, c * v - s * y
    frames.second[2, e] = c * w - s * z


@kernel
def renew(q, tangent, frames):
    """Make the present frames, without their angles, the state's references."""
    if frames is None:
        return
    for e in range(1, q.shape[0]):
        c, s = math.cos(q[e, ANGLE]), math.sin(q[e, ANGLE])
        along, square = 0.0, 0.0
        for k in range(3):
            q[e, REFERENCE + k] = tangent[k, e]
            q[e, REFERENCE + 3 + k] = c * frames.first[k, e] - s * frames.second[k, e]
            along += q[e, REFERENCE + 3 + k] * tangent[k, e]
        for k in range(3):
            q[e, REFERENCE + 3 + k] -= along * tangent[k, e]
            square += q[e, REFERENCE + 3 + k] ** 2
        for k in range(3):
            q[e, REFERENCE + 3 + k] /= math.sqrt(square)


@kernel
def clear_forces(frames):
    """Set to zero what terms add to."""
    if frames is None:
        return
    frames.by_strain[:] = 0.0


@inlined
def fill_relative(tangent, i, frames):
    """Fill Q of a vertex: the right frame's axes in the left frame."""
    q, first, second = frames.relative, frames.first, frames.second
    q[:] = 0.0
    for k in range(3):
        a, b, c = first[k, i], second[k, i], tangent[k, i]
        x, y, z = first[k, i + 1], second[k, i + 1], tangent[k, i + 1]
        q[0, 0] += a * x
        q[0, 1] += a * y
        q[0, 2] += a * z
        q[1, 0] += b * x
        q[1, 1] += b * y
        q[1, 2] += b * z
        q[2, 0] += c * x
        q[2, 1] += c * y
        q[2, 2] += c * z


@inlined
def fill_rows(frames):
    """Fill the first derivatives of the three skew parts, of Q_11 + Q_22 and of Q_33, by body rotations."""
    q, rows = frames.relative, frames.rows
    trace = q[0, 0] + q[1, 1] + q[2, 2]
    for k in range(3):
        k1, k2 = (k + 1) % 3, (k + 2) % 3
        skew = q[k2, k1] - q[k1, k2]
        for m in range(3):
            rows[k, m] = q[k, m]
            rows[k, 3 + m] = -q[m, k]
        rows[k, k] -= trace
        rows[k, 3 + k] += trace
        rows[3, k] = skew
        rows[3, 3 + k] = -skew
    rows[4, 0], rows[4, 1], rows[4, 2] = -q[1, 2], q[0, 2], 0.0
    rows[4, 3], rows[4, 4], rows[4, 5] = -q[2, 1], q[2, 0], 0.0
    for m in range(6):
        rows[3, m] -= rows[4, m]


@inlined
def fill_strain(fall, i, frames):
    """Fill the strains of a vertex and their slopes; ``fall`` is 1 - cos(phi)."""
    q, rows, slope = frames.relative, frames.rows, frames.slope
    fill_rows(frames)
    f, by_fall, _ = over_sine(fall)
    for j in range(2):
        j1, j2 = (j + 1) % 3, (j + 2) % 3
        skew = q[j2, j1] - q[j1, j2]
        frames.strain[j, i] = 0.5 * f * skew
        for m in range(6):
            slope[i, j, m] = 0.5 * (f * rows[j, m] - by_fall * skew * rows[4, m])
    s, c = q[1, 0] - q[0, 1], q[0, 0] + q[1, 1]
    frames.strain[2, i] = math.atan2(s, c)
    for m in range(6):
        slope[i, 2, m] = (c * rows[2, m] - s * rows[3, m]) / (c * c + s * s)


@kernel
def add_moments(kin, grad, r, frames):
    """Turn derivatives by strains into those by edges, and by angles, which are rows of the residual."""
    if frames is None:
        return
    n = kin.rest.size - 2
    frames.moment[:] = 0.0
    for i in range(n + 1):
        for j in range(3):
            for m in range(3):
                force = frames.by_strain[j, i]
                frames.moment[i, m] += force * frames.slope[i, j, m]
                frames.moment[i + 1, m] += force * frames.slope[i, j, 3 + m]
    for e in range(1, n + 1):
        for k in range(3):
            grad.edge[k, e] += kin.inverse[e] * (
                frames.moment[e, 1] * frames.first[k, e] - frames.moment[e, 0] * frames.second[k, e]
            )
        r[e, ANGLE] = frames.moment[e, 2]
