import numpy as np
import pytest

from derod.record import profiles as fields
from tests.synthetic import small_scene


def test_curvature_of_a_circle():
    edges, radius = 200, 0.7
    angle = np.linspace(0, 2 * np.pi, edges + 1)
    x = radius * np.stack([np.sin(angle), 1 - np.cos(angle), 0 * angle], axis=1)[:, [2, 1, 0]]
    s = np.linalg.norm(x[1] - x[0]) * np.arange(edges + 1)
    assert fields.curvature(x, s)[1:-1] == pytest.approx(np.full(edges - 1, 1 / radius), rel=1e-3)


def test_wall_push_is_the_slope_of_the_wall():
    scene = small_scene()
    v0, rho = scene.drop.wall_strength, scene.drop.wall_softness
    for r in (0.1, 0.4, 0.52):
        step = 1e-6
        slope = (v0 / (1 + rho - 2 * (r + step)) - v0 / (1 + rho - 2 * (r - step))) / (2 * step)
        push = fields.wall_push(np.array([[r, 0.0, 0.0]]), np.zeros(3), scene)
        assert push[0] == pytest.approx(slope, rel=1e-6)
    assert fields.wall_push(np.array([[2.0, 0, 0]]), np.zeros(3), scene)[0] == 0


def test_wetted_nodes_include_the_menisci():
    s = np.linspace(0, 10, 11)
    assert np.flatnonzero(fields.wetted(s, np.array(3.0), np.array(5.0))).tolist() == [3, 4, 5]


@pytest.mark.parametrize("name", fields.FIELDS)
def test_colours_span_the_scale(name):
    scale = fields.coloring(name, small_scene())
    painted = fields.paint(np.array([scale.low - 9, scale.high + 9]), scale)
    assert painted.tolist() == [list(scale.colors[0]), list(scale.colors[-1])]


def test_an_unknown_field_is_refused():
    with pytest.raises(ValueError, match="curvature, tension, wall, twist"):
        fields.coloring("mood", small_scene())


def test_node_tension_is_the_mean_of_its_edges():
    assert fields.node_tension(np.array([1.0, 3.0, 5.0])).tolist() == [1, 2, 4, 5]
