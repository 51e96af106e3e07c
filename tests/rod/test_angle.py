import numpy as np
import pytest

from derod.rod.angle import SERIES_LIMIT, squared_angle


@pytest.mark.parametrize("phi", [1e-9, 1e-3, 0.1, 0.3, 0.345, 0.35, 1.0, 2.0, 3.0])
def test_value_and_derivatives(phi: float) -> None:
    u = 2 * np.sin(phi / 2) ** 2
    value, first, second = squared_angle(u)
    assert value == pytest.approx(phi**2, rel=1e-13)
    assert first == pytest.approx(2 * phi / np.sin(phi), rel=1e-12)
    exact = 2 * (np.sin(phi) - phi * np.cos(phi)) / np.sin(phi) ** 3 if phi > 1e-2 else 2 / 3
    assert second == pytest.approx(exact, rel=1e-6 if phi < 0.05 else 1e-9)


def test_series_meets_the_closed_form() -> None:
    below, above = SERIES_LIMIT * (1 - 1e-12), SERIES_LIMIT * (1 + 1e-12)
    np.testing.assert_allclose(squared_angle(below), squared_angle(above), rtol=1e-10)
