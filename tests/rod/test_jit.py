"""What the ways to compile a kernel promise."""

from __future__ import annotations

import numpy as np
import pytest
from numba.core.errors import NumbaError

from derod.algebra.jit import allocating_kernel, inlined, kernel


def doubled(x):
    return 2 * x


def test_a_kernel_that_allocates_is_refused() -> None:
    def into(x, y):
        y[:] = 2 * x

    with pytest.raises(NumbaError, match="NRT required"):
        kernel(into)(np.ones(3), np.ones(3))


def test_an_inlined_part_that_allocates_is_refused_in_its_kernel() -> None:
    part = inlined(doubled)

    def whole(x):
        return part(x)[0]

    with pytest.raises(NumbaError, match="NRT required"):
        kernel(whole)(np.ones(3))


def test_an_allocating_kernel_may() -> None:
    np.testing.assert_array_equal(allocating_kernel(doubled)(np.ones(3)), [2, 2, 2])


def test_nan_is_seen_and_division_by_zero_is_as_in_ieee() -> None:
    def divide(x, y):
        z = x / y
        return z, np.isnan(z - z)

    assert kernel(divide)(1.0, 0.0) == (np.inf, True)
