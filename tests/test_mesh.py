import numpy as np
import pytest

from derod.rod.mesh import dry_mesh, quadrature, wetted_mesh
from derod.scene.tables import Mesh


@pytest.mark.parametrize("edges", [12, 13, 100, 201])
def test_fractions_fill_the_wetted_length_and_mirror(edges):
    mesh = wetted_mesh(Mesh(edges=edges), 0.2)
    assert mesh.edges == edges
    assert mesh.inside.sum() == pytest.approx(1, abs=1e-14)
    assert mesh.inside == pytest.approx(mesh.inside[::-1], abs=1e-15)


@pytest.mark.parametrize(
    "fractions", [np.full(3, 1 / 3), np.full(8, 1 / 8), wetted_mesh(Mesh(edges=40), 0.2).inside]
)
def test_quadrature_is_exact_for_cubics_and_mirrors(fractions):
    weights = quadrature(fractions)
    nodes = np.concatenate(([0.0], np.cumsum(fractions)))
    for power in range(4):
        assert weights @ nodes**power == pytest.approx(1 / (power + 1), abs=1e-14)
    assert (weights == weights[::-1]).all()
    assert (weights > 0).all()


def test_quadrature_of_a_graded_mesh_is_of_fourth_order():
    errors = []
    for edges in (40, 80, 160, 320):
        mesh = wetted_mesh(Mesh(edges=edges), 0.2)
        nodes = np.concatenate(([0.0], np.cumsum(mesh.inside)))
        errors.append(abs(mesh.quadrature @ np.exp(3 * nodes) - np.expm1(3) / 3))
    rates = np.log2(np.array(errors[:-1]) / errors[1:])
    assert rates.min() > 3.9


def test_a_dry_mesh_is_uniform_and_has_no_wetted_part():
    mesh = dry_mesh(7)
    assert mesh.edges == 7
    assert mesh.outside == 0
    assert mesh.quadrature.size == 0


def test_strong_capillarity_gets_shorter_edges_beside_the_menisci():
    weak, strong = (wetted_mesh(Mesh(edges=100), f**-0.5) for f in (20.0, 500.0))
    assert weak.layer == pytest.approx(0.5 / np.sqrt(20))
    assert weak.layer / strong.layer == pytest.approx(5)
