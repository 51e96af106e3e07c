"""One BLAS thread: the matrices here have at most forty rows, and threads cost ten times their work."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache, wraps
from typing import ParamSpec, TypeVar

from threadpoolctl import ThreadpoolController

_P = ParamSpec("_P")
_T = TypeVar("_T")


@cache
def _controller() -> ThreadpoolController:
    """The thread pools of the libraries loaded by now (numpy's and scipy's BLAS among them)."""
    return ThreadpoolController()


def one_blas_thread(work: Callable[_P, _T]) -> Callable[_P, _T]:
    """A function that runs with one BLAS thread and gives the caller's number back afterwards."""

    @wraps(work)
    def limited(*args: _P.args, **kwargs: _P.kwargs) -> _T:
        with _controller().limit(limits=1, user_api="blas"):
            return work(*args, **kwargs)

    return limited
