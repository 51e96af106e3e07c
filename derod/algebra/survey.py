"""Which kernels a piece of work needs, and for which types, found by doing it in plain Python.

While ``survey`` is on, numba's kernels are Python functions: on a dozen edges an increment takes a tenth of
a second, and compiles nothing. Kernels come in the order in which they can be compiled: one that is called
by another comes before it.
"""

from __future__ import annotations

import contextlib
from collections.abc import Callable
from typing import Any, NamedTuple

PATIENCE = 20_000  # calls of kernels and their parts without anything new, about 0.3 s


class Wanted(NamedTuple):
    """A kernel for one tuple of types."""

    kernel: Any  # numba's dispatcher
    types: tuple[Any, ...]

    @property
    def name(self) -> str:
        """The function's name."""
        return str(self.kernel.py_func.__name__)

    def is_kept(self) -> bool:
        """Whether it need not be compiled: it is loaded, or in the cache, or in the package."""
        if self.types in self.kernel.overloads:
            return True
        cache = self.kernel._cache
        file = getattr(cache, "_cache_file", None)
        if file is None:  # not cached at all
            return False
        key = cache._index_key(self.types, self.kernel.targetctx.codegen())
        return file.load(key) is not None

    def compile(self) -> None:
        """Load it, or compile and keep it."""
        self.kernel.compile(self.types)


class _Enough(BaseException):
    """Ends a survey where nothing new is to be expected: BaseException, so that no solver catches it."""


def survey(work: Callable[[], object], patience: int = PATIENCE) -> list[Wanted]:
    """Do ``work`` in plain Python and return the kernels that it calls.

    It ends with the work, or when the last ``patience`` calls brought nothing new, or when a number does in
    Python what it does not in a kernel (a division by zero is an error): what is then not in the list will
    be compiled when it is called.
    """
    import numpy as np
    from numba import typeof
    from numba.core.dispatcher import Dispatcher

    found: dict[tuple[Any, ...], Wanted | None] = {}
    since = depth = 0

    def call(self: Any, *arguments: Any) -> Any:
        nonlocal since, depth
        since += 1
        if since > patience:
            raise _Enough
        if depth and self.targetoptions.get("inline", "never") != "never":
            return self.py_func(*arguments)  # a part of the kernel that calls it
        wanted = Wanted(self, tuple(typeof(value) for value in arguments))
        key = (id(self), wanted.types)
        new = key not in found
        if new:
            found[key], since = None, 0
        depth += 1
        try:
            return self.py_func(*arguments)
        finally:
            depth -= 1
            if new:  # at the end of the row: those that it calls are there by now
                del found[key]
                found[key] = wanted

    before = Dispatcher.__dict__.get("__call__")
    setattr(Dispatcher, "__call__", call)  # noqa: B010  a method, to mypy
    try:
        with contextlib.suppress(_Enough, ArithmeticError), np.errstate(all="ignore"):
            work()
    finally:
        if before is None:
            delattr(Dispatcher, "__call__")
        else:
            setattr(Dispatcher, "__call__", before)  # noqa: B010
    return [wanted for wanted in found.values() if wanted is not None]
