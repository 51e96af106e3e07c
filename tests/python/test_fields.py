"""Curvature, moment, directors and the wall's pressure of recorded increments, held against mechanics."""

from __future__ import annotations

import numpy as np
import pytest

import derod
from derod.record import BaseRun
from tests.scenes import coil


@pytest.mark.parametrize("i", [0, 10, -1])
def test_directors(run: BaseRun, i: int) -> None:
    d = run.directors(i)
    nodes = run.scene.mesh.edges + 1
    frames = np.stack(d, axis=1)  # (N+1, 3 vectors, 3)
    assert frames.shape == (nodes, 3, 3)
    assert abs(frames @ frames.transpose(0, 2, 1) - np.eye(3)).max() < 1e-12
    assert np.linalg.det(frames) == pytest.approx(np.ones(nodes))
    assert abs(frames[0] - np.eye(3)).max() < 1e-12, "the start clamp's"
    angle = run[i].end_rotation
    cos, sin = np.cos(angle), np.sin(angle)
    end = np.array([[cos, sin, 0.0], [-sin, cos, 0.0], [0.0, 0.0, 1.0]])
    assert abs(frames[-1] - end).max() < 1e-6, "the end clamp's, turned by R"


def test_the_frame_twists_uniformly(run: BaseRun) -> None:
    """u3 = d1' . d2 is the recorded twist all along, up to the mesh."""
    errors = []
    for edges in (60, 120):
        made = derod.push(coil(edges=edges, rotation=1.5, stop='"0.4 pi"'))
        d, s, row = made.directors(-1), made.arc_length(-1), made[-1]
        twist = (row.end_rotation - row.holonomy) / made.scene.rod.length
        step = np.diff(s)
        turn = np.einsum("ij,ij->i", d.d1[1:] - d.d1[:-1], 0.5 * (d.d2[1:] + d.d2[:-1])) / step
        errors.append(abs(turn - twist).max())
    assert errors[1] < 0.02 and errors[1] < 0.5 * errors[0], errors


def force_of_moments(run: BaseRun) -> tuple[np.ndarray, float]:
    """n of m - m_0 = -(r - r_0) x n, fitted outside the drop, and what is left of m, relative."""
    x, m = run.positions(-1), run.moment(-1)
    outside = np.flatnonzero(run.arc_length(-1) < run[-1].meniscus_a - 0.1)
    x, m = x[outside] - x[0], m[outside]
    cross = np.stack([-np.cross(x, axis) for axis in np.eye(3)], axis=2)
    ones = np.broadcast_to(np.eye(3), cross.shape)
    matrix = np.concatenate([cross, ones], axis=2).reshape(-1, 6)
    fitted, *_ = np.linalg.lstsq(matrix, m.ravel(), rcond=None)
    left = abs(matrix @ fitted - m.ravel()).max()
    return fitted[:3], float(left / np.linalg.norm(m, axis=1).max())


def test_moments_balance_the_end_tension(run: BaseRun) -> None:
    """Outside the drop m' = -t x n with a constant n, and n_z = t: to second order in the edge length."""
    coarse = derod.push(coil(edges=60, rotation=1.5, stop='"0.5 pi"', at='["0.3 pi"]'))
    errors, left = [], []
    for made in (coarse, run):
        force, rest = force_of_moments(made)
        errors.append(abs(force[2] - made[-1].end_tension) / made[-1].end_tension)
        left.append(rest)
        assert abs(force[:2]).max() < 1e-3 * force[2]
    assert errors[1] < 0.01 and errors[1] < errors[0] / 3, errors
    assert left[1] < 2e-3 and left[1] < left[0] / 2, left


def test_the_moments_twist(run: BaseRun) -> None:
    row, rod = run[-1], run.scene.rod
    along = np.einsum("ij,ij->i", run.moment(-1), run.directors(-1).d3)
    expected = rod.twisting * (row.end_rotation - row.holonomy) / rod.length
    assert along == pytest.approx(np.full(len(along), expected), abs=0.02)
    bend = np.linalg.norm(np.cross(run.moment(-1), run.directors(-1).d3), axis=1)
    assert bend == pytest.approx(rod.bending * run.curvature(-1), rel=1e-2, abs=1e-3)


def test_the_drop_is_held_by_nothing_else(run: BaseRun) -> None:
    """The wall's push and the menisci's forces on the rod sum to zero: the drop has no weight."""
    row, s = run[-1], run.arc_length(-1)
    inward = run.drop_center(-1) - run.positions(-1)
    inward /= np.linalg.norm(inward, axis=1)[:, None]
    pressure = run.wall_pressure(-1)
    wet = (s >= row.meniscus_a - 1e-9) & (s <= row.meniscus_b + 1e-9)
    assert (pressure[wet] > 0).all() and (pressure[~wet] == 0).all()
    push = np.trapezoid((pressure[:, None] * inward)[wet], s[wet], axis=0)
    a, b = np.flatnonzero(wet)[[0, -1]]
    total = push + row.force_a * inward[a] + row.force_b * inward[b]
    assert np.linalg.norm(total) < 2e-3 * row.force_a


def test_without_a_drop_no_wall() -> None:
    scene = derod.Scene(coil(stop='"0.05 pi"'), {"model.drop": False, "drop": None})
    dry = derod.push(scene)
    assert (dry.wall_pressure(-1) == 0).all() and dry.directors(-1).d1.shape == (61, 3)


def test_si_and_stiffness_scale(run: BaseRun) -> None:
    """All stiffnesses and forces doubled: the same shapes, moments and pressures doubled."""
    base = coil(edges=60, rotation=1.5, stop='"0.1 pi"')
    twice = base.replace(
        {
            "rod.bending": 2,
            "rod.twisting": 1.8,
            "drop.capillary_force": 40,
            "drop.wall_strength": 4e-4,
        }
    )
    one, two = derod.push(base), derod.push(twice)
    assert two.moment(-1) == pytest.approx(2 * one.moment(-1), rel=1e-6, abs=1e-6)
    assert two.wall_pressure(-1) == pytest.approx(2 * one.wall_pressure(-1), rel=1e-5)
    assert two.modes(-1, 2).eigenvalues == pytest.approx(2 * one.modes(-1, 2).eigenvalues, rel=1e-5)
