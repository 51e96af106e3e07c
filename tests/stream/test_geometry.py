from itertools import pairwise

import numpy as np
import pytest

from derod.record.geometry import (
    edge_tangents,
    material_frame,
    rotate,
    sphere,
    transports,
    tube,
    tube_triangles,
)


def curve_of(tangents: np.ndarray, length: float = 1.0) -> tuple[np.ndarray, np.ndarray]:
    step = length / len(tangents)
    nodes = np.concatenate([np.zeros((1, 3)), np.cumsum(step * tangents, axis=0)])
    return nodes, step * np.arange(len(tangents) + 1)


def cone(half_angle: float, edges: int = 2000) -> tuple[np.ndarray, np.ndarray]:
    """A curve whose tangent leaves e_z, goes once around a cone about it, and comes back."""
    down = np.linspace(0, half_angle, 200)
    around = np.linspace(0, 2 * np.pi, edges)
    polar = np.concatenate([down, np.full(edges, half_angle), down[::-1]])
    azimuth = np.concatenate([np.zeros(200), around, np.zeros(200)])
    tangents = np.stack(
        [np.sin(polar) * np.cos(azimuth), np.sin(polar) * np.sin(azimuth), np.cos(polar)], axis=1
    )
    return curve_of(tangents)


def wavy(edges: int = 120) -> tuple[np.ndarray, np.ndarray]:
    u = np.linspace(0, 1, edges)
    tangents = np.stack(
        [0.8 * np.sin(7 * u) * u * (1 - u), np.sin(2 * np.pi * u) * 0.9, np.ones(edges)], axis=1
    )
    return curve_of(tangents / np.linalg.norm(tangents, axis=1)[:, None])


@pytest.mark.parametrize("half_angle", [0.3, 1.0, 2.2])
def test_holonomy_is_the_area_that_the_tangent_encloses(half_angle):
    positions, _ = cone(half_angle)
    q = transports(positions)[-1]
    turn = 2 * np.arctan2(q[3], q[0])
    area = 2 * np.pi * (1 - np.cos(half_angle))
    assert q[1:3] == pytest.approx([0, 0], abs=1e-6)
    assert np.cos(turn - area) == pytest.approx(1, abs=1e-5)


def test_products_are_those_taken_one_by_one():
    from derod.record.geometry import quaternion_product, tangents_with_clamps

    positions, _ = wavy(37)
    t = tangents_with_clamps(positions)
    q = np.array([1.0, 0, 0, 0])
    for a, b in pairwise(t):
        p = np.array([1 + a @ b, *np.cross(a, b)])
        q = quaternion_product(p / np.linalg.norm(p), q)
    assert transports(positions)[-1] == pytest.approx(q, abs=1e-12)


def test_the_frame_is_orthonormal_and_its_d3_the_tangent():
    positions, s = wavy()
    frame = material_frame(positions, s, 3.0)
    axes = np.stack(frame, axis=1)
    assert axes @ axes.transpose(0, 2, 1) == pytest.approx(np.broadcast_to(np.eye(3), (121, 3, 3)))
    middle = edge_tangents(positions)
    assert np.all(np.sum(frame.d3[1:-1] * (middle[:-1] + middle[1:]) / 2, axis=1) > 0.999)


def test_a_planar_rod_keeps_its_normal_and_twist_turns_it():
    u = np.linspace(0, 1, 400)
    angle = 1.2 * np.sin(2 * np.pi * u)
    positions, s = curve_of(np.stack([0 * u, np.sin(angle), np.cos(angle)], axis=1), 5.0)
    flat = material_frame(positions, s, 0.0)
    assert flat.d1 == pytest.approx(np.broadcast_to([1.0, 0, 0], flat.d1.shape), abs=1e-12)
    u3 = 2 * np.pi / 5.0
    twisted = material_frame(positions, s, u3)
    middle = twisted.d1[200]
    along = edge_tangents(positions)[200]
    assert middle @ np.array([1.0, 0, 0]) == pytest.approx(np.cos(u3 * s[200]), abs=1e-3)
    assert abs(middle @ along) < 0.05


def test_many_curves_at_once_are_the_same_as_one_by_one():
    curves = [wavy(50), cone(0.7, 50 + 0)]
    curves[1] = (wavy(50)[0] @ np.diag([1.0, -1.0, 1.0]), curves[0][1])
    x, s = (np.stack(part) for part in zip(*curves, strict=True))
    both = material_frame(x, s, np.array([0.5, -2.0]))
    for i, u3 in enumerate((0.5, -2.0)):
        assert both.d1[i] == pytest.approx(material_frame(x[i], s[i], u3).d1, abs=1e-12)


def test_tube_vertices_lie_at_its_radius_and_triangles_close_it():
    positions, s = wavy(10)
    vertices, normals = tube(positions, material_frame(positions, s, 0.0), 0.1, 6)
    assert vertices.shape == normals.shape == (66, 3)
    away = np.linalg.norm(vertices.reshape(11, 6, 3) - positions[:, None], axis=-1)
    assert away == pytest.approx(np.full((11, 6), 0.1))
    triangles = tube_triangles(11, 6)
    assert triangles.shape == (120, 3)
    assert triangles.min() == 0
    assert triangles.max() == 65


def test_sphere():
    vertices, triangles = sphere(0.5, 8, 12)
    assert np.linalg.norm(vertices, axis=1) == pytest.approx(np.full(len(vertices), 0.5))
    assert triangles.max() == len(vertices) - 1


def test_rotate_about_the_axis():
    quarter = np.array([np.sqrt(0.5), 0, 0, np.sqrt(0.5)])
    assert rotate(quarter, np.array([1.0, 0, 0])) == pytest.approx([0, 1, 0])
