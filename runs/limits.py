# ruff: noqa: E402 - threads are set before numpy is imported
"""What is left between us and the machine: kernels against its peaks, LAPACK, and a cold start.

    python runs/limits.py            kernels, shares of a push, LAPACK (a minute; more while kernels compile)
    python runs/limits.py --cold     the time from ``derod push`` to its end, kernels compiled or not

Flops and bytes are counted by hand from the sources, for a rod in space: additions, multiplications,
divisions and roots count one each, loads and stores 8 bytes, and a node in the drop is charged to 0.65 edges.
The machine's peaks are measured in the same run, in numba as well: a scalar chain-free multiply-add, the same
on vectors, and the triad a = b + s c in the first cache. A kernel's roof is the slower of its arithmetic (on
vectors where its loops allow that) and its traffic with the first cache.
"""

from __future__ import annotations

import os

for name in ("OPENBLAS_NUM_THREADS", "NUMBA_NUM_THREADS", "OMP_NUM_THREADS"):
    os.environ.setdefault(name, "1")

import argparse
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import NamedTuple

import derod

# isort: split
import numpy as np
from bench.stepping import explicit_step, implicit_step, pushed
from numba import njit
from scipy.linalg import lapack

from derod.algebra import bordered
from derod.equilibrium.system import System
from derod.rod import assembly

HERE = Path(__file__).parent
MESHES = (100, 200, 800)
BATCHES, REPEATS = 12, 60


class Work(NamedTuple):
    """What a kernel does for an edge, in space, with a drop."""

    flops: float
    numbers: float  # loaded or stored, 8 bytes each
    vectors: bool  # whether its loops can run on vectors

    def roof(self, peak: dict[str, float]) -> float:
        """Return the least time that the machine could take, ns: by arithmetic or by the first cache."""
        speed = peak["vector" if self.vectors else "scalar"]
        return max(self.flops / speed, 8 * self.numbers / peak["bytes"])


WORK = {
    "kinematics": Work(75, 85, True),
    "forces and constraints": Work(330, 335, True),
    "Hessian, assembled": Work(2900, 650, False),
    "factorisation": Work(4 * 2 * (14 * 15 / 2 + 14 * 10 + 10 * 10), 3100, False),
    "solution, refined": Work(3 * 4 * (4 * 14 + 4 * 10), 1000, False),
}


@njit(error_model="numpy")
def triad(a, b, c, s, repeats):
    """Stream: a = b + s c."""
    for _ in range(repeats):
        for i in range(a.size):
            a[i] = b[i] + s * c[i]


@njit(error_model="numpy")
def vectors(a, s, repeats):
    """Many multiply-adds on what is in the cache, on vectors."""
    for _ in range(repeats):
        for i in range(a.size):
            x = a[i]
            for _ in range(16):
                x = x * s + 1e-9
            a[i] = x


@njit(error_model="numpy")
def scalars(n, s):
    """Eight independent chains of multiply-adds."""
    a, b, c, d, e, f, g, h = 1.0, 1.1, 1.2, 1.3, 1.4, 1.5, 1.6, 1.7
    for _ in range(n):
        a, b, c, d = a * s + 1e-9, b * s + 1e-9, c * s + 1e-9, d * s + 1e-9
        e, f, g, h = e * s + 1e-9, f * s + 1e-9, g * s + 1e-9, h * s + 1e-9
    return a + b + c + d + e + f + g + h


def least(work: Callable[[], object], batches: int = BATCHES) -> float:
    """Return the least time of a call, s."""
    work()
    best = np.inf
    for _ in range(batches):
        clock = time.perf_counter()
        work()
        best = min(best, time.perf_counter() - clock)
    return float(best)


def peaks() -> dict[str, float]:
    """Return what the machine does at best: GFlop/s and GB/s."""
    a, b, c = np.zeros(1024), np.ones(1024), np.ones(1024)
    return {
        "scalar": 16 * 1e5 / least(lambda: scalars(100_000, 0.999)) / 1e9,
        "vector": 1024 * 32 * 200 / least(lambda: vectors(b, 0.999, 200)) / 1e9,
        "bytes": 24 * 1024 * 1000 / least(lambda: triad(a, b, c, 2.0, 1000)) / 1e9,
    }


def kernels(system: System, state) -> dict[str, float]:
    """Return the time of each kernel, s: loops of calls inside compiled code."""
    p, m, room, factor = system.physics, system.mesh, system.room, system.factor
    q, b, psi, turn = state.q, state.b, state.holonomy, system.end_rotation

    @njit(error_model="numpy")
    def kinematics(p, m, q, b, kin, n):
        for _ in range(n):
            assembly.measure(p, m, q, b, kin)

    @njit(error_model="numpy")
    def gradient(p, m, q, b, psi, turn, room, n):
        for _ in range(n):
            assembly.gradient(p, m, q, b, psi, turn, room)

    @njit(error_model="numpy")
    def hessian(p, q, b, psi, turn, room, n):
        for _ in range(n):
            assembly.hessian(p, q, b, psi, turn, room)

    @njit(error_model="numpy")
    def factorize(linear, factor, n):
        for _ in range(n):
            bordered.factorize(linear, factor)

    @njit(error_model="numpy")
    def solve(linear, factor, n):
        for _ in range(n):
            factor.rhs[:] = 1.0
            factor.rhs_border[:] = 1.0
            bordered.solve_refined(linear, factor)

    n = REPEATS
    return {
        "kinematics": least(lambda: kinematics(p, m, q, b, room.kin, n)) / n,
        "forces and constraints": least(lambda: gradient(p, m, q, b, psi, turn, room, n)) / n,
        "Hessian, assembled": least(lambda: hessian(p, q, b, psi, turn, room, n)) / n,
        "factorisation": least(lambda: factorize(room.linear, factor, n)) / n,
        "solution, refined": least(lambda: solve(room.linear, factor, n)) / n,
    }


def banded(system: System) -> tuple[float, float]:
    """Return LAPACK's banded solve (dgbsv) of the same band, with 1 and with 11 right sides, s."""
    linear = system.room.linear
    width = linear.band.shape[1] - 1
    n = linear.band.shape[0] - width
    lower = linear.band[:n]
    band = np.zeros((3 * width + 1, n), order="F")
    for k in range(width + 1):
        band[2 * width + k, : n - k] = lower[: n - k, k]
        band[2 * width - k, k:] = lower[: n - k, k]
    one = np.ones((n, 1), order="F")
    many = np.asfortranarray(np.column_stack([linear.border[:n], np.ones(n)]))
    room, sides = np.empty_like(band), (one.copy(order="F"), many.copy(order="F"))

    def solve(right: np.ndarray, side: np.ndarray) -> None:
        room[:], side[:] = band, right
        *_, info = lapack.dgbsv(width, width, room, side, overwrite_ab=True, overwrite_b=True)
        assert info == 0

    return least(lambda: solve(one, sides[0]), 60), least(lambda: solve(many, sides[1]), 60)


def study() -> Iterator[str]:
    """All tables but the cold start's."""
    best = peaks()
    yield (
        f"This machine, one core: {best['scalar']:.1f} GFlop/s on scalars, {best['vector']:.1f} on "
        f"vectors, {best['bytes']:.0f} GB/s from the first cache."
    )
    base = derod.load_scene(HERE / "paper-text.toml").replace(
        {"push.at": [], "push.stop": "0.5 pi"}
    )
    measured = {}
    for edges in MESHES:
        system, state = pushed(base.replace({"mesh.edges": edges}))
        times = kernels(system, state)
        system.gradient(state)
        whole = implicit_step(system, state), explicit_step(system, state), *banded(system)
        measured[edges] = times, whole
    yield (
        "\n| kernel | flops an edge | bytes an edge | roof, ns an edge | "
        + " | ".join(f"measured at {edges}" for edges in MESHES)
        + " | GFlop/s at 200 | roof / measured |"
    )
    yield "|---|---|---|---|" + "---|" * (len(MESHES) + 2)
    for kernel, work in WORK.items():
        cells = [1e9 * measured[edges][0][kernel] / edges for edges in MESHES]
        numbers = " | ".join(f"{cell:.0f}" for cell in cells)
        yield (
            f"| {kernel} | {work.flops:.0f} | {8 * work.numbers:.0f} | {work.roof(best):.0f} | {numbers} | "
            f"{work.flops / cells[1]:.1f} | {work.roof(best) / cells[1]:.2f} |"
        )
    yield (
        "\n| edges | implicit step, us | explicit step, us | dgbsv, us | with 11 right sides | "
        "step / dgbsv | / with 11 |"
    )
    yield "|---|---|---|---|---|---|---|"
    for edges, (_, (step, explicit, one, many)) in measured.items():
        yield (
            f"| {edges} | {1e6 * step:.0f} | {1e6 * explicit:.1f} | {1e6 * one:.0f} | "
            f"{1e6 * many:.0f} | {step / one:.2f} | {step / many:.2f} |"
        )
    yield from shares(measured[200][0])


def shares(times: dict[str, float]) -> Iterator[str]:
    """Where a whole push of paper-text at 200 edges spends its time."""
    scene = derod.load_scene(HERE / "paper-text.toml")
    run = derod.push(scene)
    memory = least(lambda: derod.push(scene), 5)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "run.h5"
        file = least(lambda: derod.push(scene, path, overwrite=True).close(), 5)
    rows, steps = len(run), int(run.table["iterations"].sum())
    solves = steps + rows  # every row is analysed once
    parts = {
        "assembly (forces, Hessian)": solves
        * (times["forces and constraints"] + times["Hessian, assembled"]),
        "factorisation": solves * times["factorisation"],
        "solution": solves * times["solution, refined"],
    }
    parts["chord steps, line search, prediction, Python"] = memory - sum(parts.values())
    parts["record (HDF5, every increment committed)"] = file - memory
    yield (
        f"\nA push of paper-text: {rows} increments, {steps} Newton iterations "
        f"({steps / rows:.1f} an increment), {file:.2f} s into a file."
    )
    yield "\n| part | s | share |\n|---|---|---|"
    for part, seconds in parts.items():
        yield f"| {part} | {seconds:.3f} | {100 * seconds / file:.0f} % |"


def cold_start() -> Iterator[str]:
    """``derod push`` of a few increments with an empty cache, twice: then with a full one."""
    yield "| kernels | derod push of 0.01 pi, s |\n|---|---|"
    with tempfile.TemporaryDirectory() as folder:
        command = [sys.executable, "-m", "derod", "push", str(HERE / "paper-text.toml"), "--stop"]
        command += ["0.01 pi", "--quiet", "--force", "-o", str(Path(folder) / "run.h5")]
        keep = {k: v for k, v in os.environ.items() if "NUMBA_CACHE" not in k}
        for name in ("compiled by this push", "cached", "cached, once more"):
            clock = time.perf_counter()
            subprocess.run(command, check=True, env={**keep, "XDG_CACHE_HOME": folder})
            yield f"| {name} | {time.perf_counter() - clock:.1f} |"


def main() -> None:
    """Print what was asked for."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--cold", action="store_true", help="the cold start only")
    for line in cold_start() if parser.parse_args().cold else study():
        print(line, flush=True)


if __name__ == "__main__":
    main()
