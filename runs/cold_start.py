"""How long the first push waits: version 0.1, this one without and with compiled kernels, in one run.

    python runs/cold_start.py [--rounds 2] [--wheel dist/derod-...-cp311-...whl]

Each round starts ``derod push runs/quick.toml`` for its first increments (to 0.002 pi) three ways, in turn,
each on an empty cache: version 0.1 (commit 9e95062), this version without compiled kernels, and one
installed from a wheel of ``runs/build_wheel.py`` (made here, for this scene, if none is given). CPU counts
all processes of the command. Then the time to the first line, into a pipe and on a terminal.
"""

from __future__ import annotations

import argparse
import os
import pty
import resource
import shutil
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).parents[1]
OLD = "9e95062"
SCENE = ROOT / "runs" / "quick.toml"
STOP = "0.002 pi"


class Took(NamedTuple):
    """What a command took."""

    wall: float  # s
    cpu: float  # s, of all its processes
    first: float  # s to the first line, of standard error or output


class Way(NamedTuple):
    """One way to run derod."""

    name: str
    python: str
    path: str | None  # of the sources; None where it is installed


def main() -> int:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--rounds", type=int, default=2, help="of all ways in turn (2)")
    parser.add_argument("--wheel", help="a wheel with kernels; made if not given")
    args = parser.parse_args()
    with tempfile.TemporaryDirectory(prefix="derod-cold-") as folder:
        work = Path(folder)
        ways = [old_way(work), Way("without kernels", sys.executable, str(ROOT))]
        ways.append(wheel_way(work, args.wheel))
        took: dict[str, list[Took]] = {way.name: [] for way in ways}
        for number in range(args.rounds):
            for way in ways:
                took[way.name].append(push(way, work / "cache" / f"{way.name} {number}"))
                one = took[way.name][-1]
                print(f"{way.name:18} {one.wall:6.1f} s wall {one.cpu:6.1f} s CPU", flush=True)
        print_table(took)
        print_first_lines(ways[1:], work)
    return 0


def old_way(work: Path) -> Way:
    """Version 0.1, unpacked."""
    folder = work / "old"
    folder.mkdir()
    archive = subprocess.run(
        ["git", "-C", str(ROOT), "archive", OLD], check=True, capture_output=True
    ).stdout
    subprocess.run(["tar", "-x", "-C", str(folder)], input=archive, check=True)
    return Way("version 0.1", sys.executable, str(folder))


def wheel_way(work: Path, wheel: str | None) -> Way:
    """A new environment in which the wheel is installed, beside the packages of this one."""
    if wheel is None:
        subprocess.run(
            [sys.executable, str(ROOT / "runs" / "build_wheel.py"), "-o", str(work), str(SCENE)],
            check=True,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )
        (made,) = work.glob("derod-*.whl")
        wheel = str(made)
    python = install(Path(wheel), work / "venv")
    return Way("wheel with kernels", python, None)


def install(wheel: Path, folder: Path) -> str:
    """Install ``wheel`` in a new environment that sees this one's other packages; return its Python."""
    subprocess.run([sys.executable, "-m", "venv", str(folder)], check=True)
    python = folder / "bin" / "python"
    subprocess.run([str(python), "-m", "pip", "install", "-q", "--no-deps", str(wheel)], check=True)
    (inside,) = folder.glob("lib/python*/site-packages")
    others = [path for path in sys.path if path.endswith("site-packages")]
    (inside / "others.pth").write_text("\n".join(others) + "\n")
    return str(python)


def environment(way: Way, cache: Path) -> dict[str, str]:
    """The environment of a command, with a cache of its own."""
    cache.mkdir(parents=True, exist_ok=True)
    names = ("CACHE_DIR", "CACHE_HOME", "PYTHONPATH")
    kept = {name: value for name, value in os.environ.items() if not name.endswith(names)}
    made = {"XDG_CACHE_HOME": str(cache), "HOME": str(cache), "OPENBLAS_NUM_THREADS": "1"}
    if way.path is not None:
        made |= {"PYTHONPATH": way.path, "DEROD_COMPILED": "no"}
    return kept | made


def command(way: Way, cache: Path) -> list[str]:
    """The push of the first increments."""
    output = str(cache / "run.h5")
    return [way.python, "-m", "derod", "push", str(SCENE), "--stop", STOP, "-o", output, "--force"]


def push(way: Way, cache: Path, *, terminal: bool = False) -> Took:
    """Run the push; standard error goes into a pipe, or to a terminal."""
    made = environment(way, cache)
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    began = time.perf_counter()
    inside, outside = pty.openpty() if terminal else os.pipe()
    process = subprocess.Popen(
        command(way, cache), cwd=cache, env=made, stdout=outside, stderr=outside
    )
    os.close(outside)
    first = read_all(inside, time.perf_counter) - began
    code = process.wait()
    wall = time.perf_counter() - began
    if code != 0:
        raise SystemExit(f"{way.name}: exit code {code}")
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    cpu = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    return Took(wall, cpu, first)


def read_all(descriptor: int, clock: Callable[[], float]) -> float:
    """Read to the end; return when the first line came."""
    first = float("nan")
    while True:
        try:
            data = os.read(descriptor, 65536)
        except OSError:  # a terminal's other end is closed
            data = b""
        if not data:
            os.close(descriptor)
            return first
        if first != first:
            first = clock()


def print_table(took: dict[str, list[Took]]) -> None:
    """Print medians, and the shares of version 0.1's."""
    old = took["version 0.1"]
    walls, cpus = (statistics.median(t[i] for t in old) for i in (0, 1))
    print("\n| first increment, empty cache | wall, s | CPU, s | of 0.1's wall | of its CPU |")
    print("|---|---|---|---|---|")
    for name, all_took in took.items():
        wall, cpu = (statistics.median(t[i] for t in all_took) for i in (0, 1))
        print(f"| {name} | {wall:.1f} | {cpu:.1f} | {wall / walls:.2f} | {cpu / cpus:.2f} |")


def print_first_lines(ways: list[Way], work: Path) -> None:
    """Print when the first line came, on an empty cache and on a full one."""
    print("\n| first line after, s | empty cache, pipe | full cache, pipe | full cache, terminal |")
    print("|---|---|---|---|")
    for way in ways:
        cache = work / "lines" / way.name
        times = [push(way, cache, terminal=terminal).first for terminal in (False, False, True)]
        print(f"| {way.name} | " + " | ".join(f"{one:.2f}" for one in times) + " |")
        shutil.rmtree(cache)


if __name__ == "__main__":
    sys.exit(main())
