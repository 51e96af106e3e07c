import numpy as np
import pytest

from derod.rod.grid import lay_grid
from tests.rod.states import LENGTH, Sample


@pytest.mark.parametrize(("s_a", "s_b"), [(1.05, 2.0), (0.02, 2.9), (1.4, 1.6)])
def test_regions_end_at_the_menisci(s_a: float, s_b: float) -> None:
    sample = Sample(3, edges=60)
    kin, b = sample.room.kin, sample.b
    b[:2] = s_a, s_b
    lay_grid(sample.mesh, LENGTH, b, kin)
    assert (kin.rest[1:-1] > 0).all()
    nodes = np.concatenate([[0], np.cumsum(kin.rest[1:-1])])
    assert nodes[kin.node_a] == pytest.approx(s_a, rel=1e-12)
    assert nodes[kin.node_b] == pytest.approx(s_b, rel=1e-12)
    assert nodes[-1] == pytest.approx(LENGTH, rel=1e-12)


@pytest.mark.parametrize("s", [0, 1])
def test_derivatives_by_the_menisci(s: int) -> None:
    sample = Sample(3, edges=60)
    kin, b = sample.room.kin, sample.b
    step = 1e-5
    lengths, slopes = [], []
    for sign in (1, -1):
        b[s] += sign * step
        lay_grid(sample.mesh, LENGTH, b, kin)
        lengths.append(kin.rest.copy())
        slopes.append(kin.slope[s].copy())
        b[s] -= sign * step
    lay_grid(sample.mesh, LENGTH, b, kin)
    np.testing.assert_allclose((lengths[0] - lengths[1]) / (2 * step), kin.slope[s], atol=1e-9)
    np.testing.assert_allclose((slopes[0] - slopes[1]) / (2 * step), kin.curve[s], atol=1e-8)
