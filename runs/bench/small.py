"""Peers on the clamped-clamped elastica that are asked alike: ``solve(settings)`` and a ``SCAN``."""

from __future__ import annotations

import contextlib
import os
import time
from collections.abc import Callable, Iterator
from importlib import import_module
from types import ModuleType
from typing import Any

from bench.elastica import exact_elastica
from bench.row import Row

FEW, SLOW = 2, 0.2  # turns, s

PEERS = {  # by name: its module, the package to install, its method
    "OpenSees": ("bench.opensees", "openseespy", "corotational beams, Newton"),
    "MuJoCo": ("bench.mujoco_cable", "'mujoco<4'", "cable of rigid bodies, damped dynamics"),
    "Exudyn": ("bench.exudyn_cable", "exudyn", "ANCF cables, Newton"),
    "scipy solve_bvp": ("bench.collocation", "scipy", "collocation, from a guessed shape"),
}
CHOSEN: dict[str, list[tuple]] = {  # from the fronts of ``python runs/peers.py tune-elastica``
    "OpenSees": [
        (100, 1, "ProfileSPD", "KrylovNewton", 1e5), (200, 1, "BandGeneral", "Newton", 1e7),
        (400, 1, "BandGeneral", "KrylovNewton", 1e6), (400, 2, "BandGeneral", "NewtonLineSearch", 1e7),
    ],
    "Exudyn": [(16, 2, 1e4, "EigenSparse"), (32, 2, 1e5, "EigenSparse"), (64, 2, 1e6, "EigenSparse")],
    "MuJoCo": [(10, 0.25, 0.25, 0.2, 0.2), (20, 0.25, 0.25, 0.2, 0.4), (40, 0.5, 0.5, 0.2, 0.4)],
    "scipy solve_bvp": [(31, 1e-2, True), (41, 1e-2, False), (41, 1e-3, False), (61, 1e-4, False)],
}  # fmt: skip


def installed() -> Iterator[tuple[str, ModuleType]]:
    """The peers that are here; one line about each that is not."""
    for name, (place, package, _) in PEERS.items():
        try:
            with quiet():
                module = import_module(place)
        except (ImportError, RuntimeError) as error:
            print(f"{name}: cannot be imported ({error}): python -m pip install {package}")
            continue
        yield name, module


@contextlib.contextmanager
def quiet() -> Iterator[None]:
    """Nothing on the terminal meanwhile: these codes print from C++."""
    kept = [os.dup(1), os.dup(2)]
    nothing = os.open(os.devnull, os.O_WRONLY)
    try:
        for number in (1, 2):
            os.dup2(nothing, number)
        yield
    finally:
        for number, old in zip((1, 2), kept, strict=True):
            os.dup2(old, number)
            os.close(old)
        os.close(nothing)


def least(works: list[Callable[[], Any]], repeats: int) -> list[tuple[Any, float, float]]:
    """(answer, wall, CPU) of each work, taken in turns: the least of each clock over the repeats.

    What is slow takes part in the first FEW of them.
    """
    best: list[tuple[Any, float, float]] = [(None, float("inf"), float("inf"))] * len(works)
    for turn in range(repeats):
        for k, work in enumerate(works):
            if turn >= FEW and best[k][1] > SLOW:
                continue
            wall, cpu = time.perf_counter(), time.process_time()
            answer = work()
            wall, cpu = time.perf_counter() - wall, time.process_time() - cpu
            best[k] = answer, min(best[k][1], wall), min(best[k][2], cpu)
    return best


def row_of(name: str, settings: Any, answer: Any, wall: float, cpu: float) -> Row:
    """A measurement, its errors against the closed form."""
    load, height = exact_elastica()
    return Row(
        "elastica", name, PEERS[name][2], settings[0], "uniform", wall, cpu,
        iterations=answer.iterations, tension_error=abs(-answer.tension / load - 1),
        shape_error=abs(answer.height - height), note=str(settings),
    )  # fmt: skip


def tuned(name: str, module: ModuleType) -> list[Row]:
    """The scan of a peer's settings: those that no other beats in CPU and error of t, cheapest first."""
    rows = []
    for settings in module.SCAN:
        with quiet():
            ((answer, wall, cpu),) = least([lambda s=settings: module.solve(s)], 2)
        if answer is not None and abs(answer.height - exact_elastica()[1]) < 0.05:
            rows.append(row_of(name, settings, answer, wall, cpu))
    front, best = [], float("inf")
    for row in sorted(rows, key=lambda row: row.cpu):
        if row.tension_error < 0.7 * best:
            front.append(row)
            best = row.tension_error
    return front
