"""One way to compile a kernel: cached, NaN-honest, divisions by zero as in IEEE, no reordered sums.

Fast-math is off on purpose. With it, a kernel compiled now and the same kernel loaded from the cache
rounded differently in the last digit (each inlined copy is optimised by itself), and a resumed run
was no longer the uninterrupted one bit for bit.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from numba import njit


def kernel(function: Callable[..., Any]) -> Any:
    """Compile ``function`` with the project's flags."""
    return njit(cache=True, error_model="numpy")(function)
