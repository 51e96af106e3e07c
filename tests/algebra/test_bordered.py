import numpy as np
import pytest

from derod.algebra.bordered import factorize, new_factor, solve, solve_refined
from derod.rod.arrays import Linear
from tests.rod.states import dense


def random_matrix(n: int, width: int, borders: int, seed: int) -> Linear:
    rng = np.random.default_rng(seed)
    band = np.zeros((n + width, width + 1))
    for j in range(n):
        count = min(width + 1, n - j)
        band[j, :count] = rng.normal(size=count)
        band[j, 0] += rng.choice([-1, 1]) * width  # indefinite
    border = np.zeros((n + width, borders))
    border[:n] = rng.normal(size=(n, borders))
    corner = rng.normal(size=(borders, borders))
    return Linear(band, border, corner + corner.T)


@pytest.mark.parametrize(("n", "width", "borders"), [(30, 3, 2), (200, 14, 10), (75, 10, 7)])
@pytest.mark.parametrize("seed", [0, 1, 2])
def test_solution_and_inertia_agree_with_dense(n: int, width: int, borders: int, seed: int) -> None:
    linear = random_matrix(n, width, borders, seed)
    matrix = dense(linear)
    factor = new_factor(*linear.band.shape, borders)
    assert factorize(linear, factor) == np.sum(np.linalg.eigvalsh(matrix) < 0)
    rng = np.random.default_rng(seed)
    right = rng.normal(size=n + borders)
    for solver in (
        lambda: solve(factor, factor.rhs, factor.rhs_border),
        lambda: solve_refined(linear, factor),
    ):
        factor.rhs[:n], factor.rhs[n:] = right[:n], 0
        factor.rhs_border[:] = right[n:]
        solver()
        found = np.concatenate([factor.rhs[:n], factor.rhs_border])
        np.testing.assert_allclose(matrix @ found, right, atol=1e-9)


def test_a_zero_pivot_is_reported() -> None:
    linear = random_matrix(30, 3, 2, 0)
    linear.band[0] = 0
    linear.band[0, 1] = 1.0
    assert factorize(linear, new_factor(*linear.band.shape, 2)) == -1
