"""Sweeps measured: what two processes gain, what a sweep costs beyond its pushes, and what survives what.

python runs/sweep_figures.py                  # all of it, some ten minutes
python runs/sweep_figures.py speed --count 40 # the grid f_gamma x l, count x count, pushes to 2 pi, 100 edges
python runs/sweep_figures.py kills --times 10 # killed at random and resumed
python runs/sweep_figures.py faults           # a worker killed, a poisonous point, a full disk

Times are CPU times of whole process trees, read from the system, so that a machine that others use gives the
same; the wall-clock ratio is printed beside them with the load at that time. Set OPENBLAS_NUM_THREADS=1.
"""

from __future__ import annotations

import argparse
import os
import random
import resource
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import derod
from derod.sweeps.files import Sweep
from derod.sweeps.journal import folder_of
from derod.sweeps.plan import Plan, make_plan
from derod.sweeps.points import Job, Result, run_point
from derod.sweeps.running import Means, Tally, run_sweep

DEROD = [sys.executable, "-m", "derod"]
POISON = 5


def grid(count: int, edges: int = 100, stop: str = "2 pi") -> Plan:
    """The grid f_gamma x l, pushed from a straight rod."""
    scene = derod.Scene("paper-text", {"mesh.edges": edges, "push.stop": stop})
    force = {"from": 10.0, "to": 40.0, "count": count}
    length = {"from": 8.0, "to": 14.0, "count": count}
    return make_plan(scene, {"drop.capillary_force": force, "rod.length": length})


def written(plan: Plan, path: Path) -> Path:
    """The plan as a sweep file of the command line."""
    scene = path.with_suffix(".scene.toml")
    scene.write_text(plan.scene.text)
    keys = "\n".join(
        f'"{s.key}" = {{from = {s.low}, to = {s.high}, count = {len(s.values)}}}'
        for s in plan.spreads
    )
    path.write_text(f'scene = "{scene.name}"\n[keys]\n{keys}\n')
    return path


def tree_time() -> float:
    """CPU seconds of this process and of its children that have ended."""
    kinds = (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)
    return sum(sum(resource.getrusage(kind)[:2]) for kind in kinds)


def speed(folder: Path, count: int) -> None:
    """The grid in one process, in two, and again: wall-clock and CPU time."""
    plan = grid(count)
    run_sweep(grid(2), folder / "warm.h5", Means())  # compiles, and loads what this process needs
    wall: dict[int, list[float]] = {1: [], 2: []}
    cpu: dict[int, list[float]] = {1: [], 2: []}
    own: dict[int, list[float]] = {1: [], 2: []}
    tables = set()
    for workers in (2, 1):
        path = folder / f"{workers}.h5"
        began, used = time.monotonic(), tree_time()
        tally = run_sweep(plan, path, Means(workers=workers))
        wall[workers].append(time.monotonic() - began)
        cpu[workers].append(tree_time() - used)
        own[workers].append(tally.seconds)
        tables.add(path.read_bytes())
        print(
            f"{count} x {count} in {workers} process{'es' if workers > 1 else ''}: "
            f"{wall[workers][-1]:.1f} s wall, {cpu[workers][-1]:.1f} s CPU of all processes, pushes' own "
            f"{tally.seconds:.1f} s; {dict(tally.outcomes)}; load {os.getloadavg()[0]:.1f}",
            flush=True,
        )
    for workers in (1, 2):
        extra = min(cpu[workers]) / min(own[workers]) - 1
        print(f"overhead with {workers}: {100 * extra:.1f} % of the pushes' own time")
    print(f"two against one: {min(wall[1]) / min(wall[2]):.2f} by the clock, "
          f"{2 * min(cpu[1]) / min(cpu[2]):.2f} by CPU time, if both cores are free")  # fmt: skip
    print(f"tables: {'the same bytes' if len(tables) == 1 else 'DIFFERENT'}")


def kills(folder: Path, times: int, seed: int = 1) -> None:
    """A sweep of two processes killed with all its workers at random times, and resumed each time."""
    plan = grid(7)
    whole, path = folder / "whole.h5", folder / "killed.h5"
    run_sweep(plan, whole, Means())
    words = [str(written(plan, folder / "killed.toml")), "-o", str(path)]
    chance, again, lost = random.Random(seed), 0, []
    for kill in range(times + 1):
        before = finished(path)
        command = [*DEROD, "sweep", *words, "--workers", "2", "--quiet"]
        process = subprocess.Popen(command, start_new_session=True)
        wanted = len(before) + chance.randint(1, 5)
        while kill < times and process.poll() is None and len(finished(path)) < wanted:
            time.sleep(0.002)
        if kill < times:
            time.sleep(0.2 * chance.random())
            os.killpg(process.pid, signal.SIGKILL)
        process.wait()
        after = finished(path)
        again += sum(after.get(name, stat) != stat for name, stat in before.items() if after)
        lost.append(len(after))
        words = ["--resume", str(path)]
    same = path.read_bytes() == whole.read_bytes()
    print(f"killed {times} times, with {lost[:-1]} of {plan.count} points kept, and resumed: "
          f"{'the uninterrupted table, byte for byte' if same else 'ANOTHER TABLE'}; "
          f"{again} finished points run again")  # fmt: skip


def finished(path: Path) -> dict[str, tuple[int, int]]:
    """Files of finished points, with what would change if they were written again."""
    if not folder_of(path).is_dir():
        return {}
    found = {}
    for entry in os.scandir(folder_of(path)):
        if entry.name[0].isdigit():
            there = entry.stat()
            found[entry.name.partition("-")[0]] = (there.st_ino, there.st_mtime_ns)
    return found


def poisoned(job: Job, point: int, changes: Mapping[str, Any]) -> Result:
    """A push, but at one point the process dies."""
    if point == POISON:
        os.kill(os.getpid(), signal.SIGKILL)
    if job.runs is not None:
        (Path(job.runs) / "process").write_text(str(os.getpid()))
    return run_point(Job(job.scene, job.path, job.rows), point, changes)


def faults(folder: Path) -> None:
    """A worker killed from outside, a point that kills, a disk that is full."""
    plan, said = grid(5), list[str]()
    whole, path = folder / "good.h5", folder / "faults.h5"
    run_sweep(plan, whole, Means())
    killed = []

    def watch(tally: Tally) -> None:
        if tally.done == 10 and not killed:
            killed.append(int((folder / "process").read_text()))
            os.kill(killed[0], signal.SIGKILL)

    means = Means(workers=2, work=poisoned, runs=str(folder), say=said.append)
    tally = run_sweep(plan, path, means, watch=watch)
    good, found = Sweep(whole).rows, Sweep(path).rows
    others = good[good["point"] != POISON].tobytes() == found.tobytes()
    print(f"a worker killed and point {POISON} poisonous: {dict(tally.outcomes)}; all other points "
          f"{'the same bytes' if others else 'DIFFERENT'}")  # fmt: skip
    for line in (*said, *(row["message"].decode() for row in Sweep(path).failures())):
        print(f"  said: {line}")
    full_disk(folder, plan)


def full_disk(folder: Path, plan: Plan) -> None:
    """The sweep on a file system of 96 kB, which is then made larger."""
    place = folder / "small"
    place.mkdir()
    mount = ["mount", "-t", "tmpfs", "-o", "size=96k", "tmpfs", str(place)]
    if subprocess.run(mount, stderr=subprocess.DEVNULL).returncode:
        print("full disk: not measured, mounting a small file system is not allowed here")
        return
    try:
        path = place / "s.h5"
        sweep = [
            *DEROD,
            "sweep",
            str(written(plan, folder / "disk.toml")),
            "-o",
            str(path),
            "--quiet",
        ]
        done = subprocess.run(sweep, capture_output=True, text=True)
        print(
            f"full disk: exit code {done.returncode}: {done.stderr.strip().replace(str(place), '')}"
        )
        subprocess.run(["mount", "-o", "remount,size=4m", str(place)], check=True)
        done = subprocess.run([*DEROD, "sweep", "--resume", str(path), "--quiet"])
        same = path.read_bytes() == (folder / "good.h5").read_bytes()
        print(f"  with room again, resumed: exit code {done.returncode}, "
              f"{'the uninterrupted table' if same else 'ANOTHER TABLE'}")  # fmt: skip
    finally:
        subprocess.run(["umount", str(place)], check=True)


def main() -> None:
    """Print what is asked for."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("what", nargs="*", default=["speed", "kills", "faults"])
    parser.add_argument("--count", type=int, default=40, help="points a side of the grid (40)")
    parser.add_argument("--times", type=int, default=10, help="kills (10)")
    args = parser.parse_args()
    with tempfile.TemporaryDirectory(prefix="derod-") as name:
        for what in args.what:
            folder = Path(name) / what
            folder.mkdir()
            if what == "speed":
                speed(folder, args.count)
            elif what == "kills":
                kills(folder, args.times)
            elif what == "faults":
                faults(folder)
            else:
                parser.error(f"{what}: allowed: speed, kills, faults")


if __name__ == "__main__":
    main()
