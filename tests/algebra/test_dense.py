"""The inverse and the inertia of small symmetric matrices against numpy."""

from __future__ import annotations

import numpy as np
import pytest

from derod.algebra.dense import invert


def symmetric(m: int, seed: int, diagonal: float = 1.0) -> np.ndarray:
    rng = np.random.default_rng(seed)
    a = rng.normal(size=(m, m))
    a += a.T
    a[np.diag_indices(m)] *= diagonal
    return a


@pytest.mark.parametrize("m", [2, 5, 10])
@pytest.mark.parametrize("diagonal", [1.0, 0.0, 100.0])
@pytest.mark.parametrize("seed", range(5))
def test_agrees_with_numpy(m: int, diagonal: float, seed: int) -> None:
    a = symmetric(m, seed, diagonal)
    found = a.copy()
    negative = invert(found, np.zeros(m))
    assert negative == np.sum(np.linalg.eigvalsh(a) < 0)
    np.testing.assert_allclose(found @ a, np.eye(m), atol=1e-10)
    np.testing.assert_allclose(found, found.T, atol=1e-13 * np.abs(found).max())


def test_a_saddle_with_zero_blocks_is_inverted_and_stays_in_its_blocks() -> None:
    """Two blocks that know nothing of each other: no number may leak from one to the other."""
    a = np.zeros((6, 6))
    a[:3, :3] = [[0, 0, 1], [0, 0, 2], [1, 2, 0.5]]
    a[:3, :3] += np.diag([0, 3, 0])
    a[3:, 3:] = symmetric(3, 4)
    found = a.copy()
    assert invert(found, np.zeros(6)) == np.sum(np.linalg.eigvalsh(a) < 0)
    np.testing.assert_allclose(found @ a, np.eye(6), atol=1e-12)
    assert not found[:3, 3:].any()


@pytest.mark.parametrize(
    "a", [np.zeros((3, 3)), np.ones((2, 2)), np.full((2, 2), np.nan), np.diag([1.0, np.inf])]
)
def test_singular_or_not_finite_is_reported(a: np.ndarray) -> None:
    assert invert(a.copy(), np.zeros(len(a))) == -1
