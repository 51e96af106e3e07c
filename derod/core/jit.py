"""One way to compile a kernel: cached, NaN-honest, divisions by zero as in IEEE."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from numba import njit

FASTMATH = {"contract", "reassoc", "arcp", "nsz"}  # leaves isnan and isfinite truthful


def kernel(function: Callable[..., Any]) -> Any:
    """Compile ``function`` with the project's flags."""
    return njit(cache=True, error_model="numpy", fastmath=FASTMATH)(function)
