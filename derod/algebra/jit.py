"""Ways to compile a kernel: cached, NaN-honest, divisions by zero as in IEEE, no reordered sums.

Fast-math is off on purpose. With it, a kernel compiled now and the same kernel loaded from the cache
rounded differently in the last digit (each inlined copy is optimised by itself), and a resumed run
was no longer the uninterrupted one bit for bit.

Kernels have no memory manager (``_nrt=False``): numba refuses to compile one that allocates ("NRT required"),
and no references are counted to the many arrays of their arguments. Nor may one return an array to
a function that counts: a reference would be given back that was never taken (seen: a corrupted heap).

A call that hands over ``Room``, sixty arrays, costs 0.2 us, and as many instructions as the work of a small
mesh: terms are therefore ``inlined`` into the kernels that sum them up.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from numba import njit

FLAGS: dict[str, Any] = {"cache": True, "error_model": "numpy", "_nrt": False}


def kernel(function: Callable[..., Any]) -> Any:
    """Compile ``function`` by itself; it may not allocate."""
    return njit(**FLAGS)(function)


def inlined(function: Callable[..., Any]) -> Any:
    """Make ``function`` a part of each kernel that calls it; it may not allocate."""
    return njit(inline="always", **FLAGS)(function)


def allocating_kernel(function: Callable[..., Any]) -> Any:
    """Compile ``function`` by itself, with numpy's allocations; not for the hot loop."""
    return njit(**FLAGS | {"_nrt": True})(function)
