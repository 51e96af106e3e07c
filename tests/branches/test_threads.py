"""Branches are computed with one BLAS thread, whatever the caller has set."""

import numpy as np
from threadpoolctl import ThreadpoolController

from derod.branches.half_rod.threads import one_blas_thread
from derod.branches.paths import compute


def blas_threads():
    pools = ThreadpoolController().info()
    return [pool["num_threads"] for pool in pools if pool["user_api"] == "blas"]


def test_one_thread_inside_and_the_callers_number_after():
    np.linalg.solve(np.eye(3), np.ones(3))
    with ThreadpoolController().limit(limits=2, user_api="blas"):
        before = blas_threads()
        inside = one_blas_thread(blas_threads)()
        after = blas_threads()
    assert set(before) == {2}
    assert set(inside) == {1}
    assert after == before


def test_computing_branches_is_limited(monkeypatch):
    seen = []

    def stop(*args):
        seen.extend(blas_threads())
        raise ValueError("far enough")

    monkeypatch.setattr(compute, "Catalogue", stop)
    try:
        compute.compute_branches(None, ["Ax"])
    except ValueError as error:
        assert str(error) == "far enough"
    assert seen == [1] * len(seen)
    assert seen
