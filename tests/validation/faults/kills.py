"""Processes killed at any moment: no committed row is lost, and nothing is left lying about."""

from __future__ import annotations

import random
import resource
import time
from pathlib import Path

import numpy as np

import derod
from derod.errors import RecordError
from derod.pushing.frames import Outcome
from derod.record import BaseRun, RunWriter, open_run
from tests.scenes import coil
from tests.synthetic import drive, is_frame, small_scene
from tests.validation.faults.trial import Found, command, ended, start, wait_until

KILLS_A_CHAIN = 5
LONGEST = 5.0  # s after its start that a process is killed at the latest


def pushed_scene() -> derod.Scene:
    """Some 1500 rows in a few seconds."""
    return coil(edges=24).replace({"push.max_step": "0.0002 pi"})


def rows_of(path: Path, found: Found) -> int:
    """The rows of a run file that opens and fits its checksums; 0 where there is none yet."""
    if not path.exists():
        return 0
    try:
        with open_run(path, verify=True) as run:
            return len(run)
    except RecordError as error:
        found.fail(f"after a kill: {error}")
        return 0


def is_the_same(run: BaseRun, whole: BaseRun) -> bool:
    """Whether two runs agree bit for bit, in all but the times they took."""
    if len(run) != len(whole) or run.outcome is not Outcome.COMPLETED:
        return False
    names = [name for name in whole.table.dtype.names or () if name != "wall_time"]
    return (
        all(run.table[name].tobytes() == whole.table[name].tobytes() for name in names)
        and all(np.array_equal(run.positions(i), whole.positions(i)) for i in range(len(whole)))
        and [event.message for event in run.events] == [event.message for event in whole.events]
    )


def kill_chains(folder: Path, kills: int, seed: int = 1, **changes: str) -> Found:
    """Push, killed; resume, killed; ...; then resumed to the end and held against the uninterrupted."""
    found = Found("kill -9 of `push` and `push --resume`: start-up, copy, push")
    chance = random.Random(seed)
    scene = pushed_scene()
    whole = derod.push(scene)
    (folder / "scene.toml").write_text(scene.text)
    chain = 0
    while found.trials < kills:
        chain += 1
        place = folder / f"chain-{chain}"
        place.mkdir()
        path = place / "run.h5"
        fresh = ["push", folder / "scene.toml", "-o", path, "--quiet"]
        before = 0
        for _ in range(min(KILLS_A_CHAIN, kills - found.trials)):
            going_on = path.exists()
            words = ["push", "--resume", path, "--quiet"] if going_on else fresh
            process = start(words, **changes)
            if chance.random() < 0.4:  # any moment
                time.sleep(chance.uniform(0.0, LONGEST))
            else:  # soon after it begins to write
                inode = path.stat().st_ino if going_on else None
                wait_until(lambda i=inode: process.poll() is not None or is_new(path, i), 20.0)  # noqa: B023
                time.sleep(chance.uniform(0.0, 1.5))
            seen = rows_of(path, found)
            process.kill()
            ended(process)
            after = rows_of(path, found)
            if after < max(seen, before):
                found.fail(f"{path.name}: {max(seen, before)} rows before a kill, {after} after it")
            if process.returncode != 0:  # else it had ended
                found.add("among rows" if after else "with no row yet")
            before = after
        words = ["push", "--resume", path, "--quiet"] if path.exists() else fresh
        code, _, said = command(*words)
        if code != 0:
            found.fail(f"resumed to {code}: {said}")
            continue
        with open_run(path, verify=True) as run:
            if not is_the_same(run, whole):
                found.fail("resumed to another table than the uninterrupted")
        left = sorted(entry.name for entry in place.iterdir())
        if left != ["run.h5"]:
            found.fail(f"left behind: {left}")
    return found


def is_new(path: Path, inode: int | None) -> bool:
    """Whether a file has come, or another has taken its place."""
    try:
        return path.stat().st_ino != inode
    except OSError:
        return False


def copy_kills(folder: Path, kills: int, seed: int = 2) -> Found:
    """Processes that do nothing but copy a run for its resume, killed."""
    found = Found("kill -9 of a resume's copy (400 rows)")
    chance = random.Random(seed)
    path = folder / "copied.h5"
    scene = small_scene(push__stop="2.6 pi", push__max_step="0.01 pi", push__at=[])
    drive(scene, [RunWriter(path)])
    with open_run(path) as run:
        count = len(run)
    for _ in range(kills):
        process = start([path], "tests.validation.faults.copying")
        assert process.stdout is not None
        process.stdout.readline()
        time.sleep(chance.uniform(0.0, 0.3))
        process.kill()
        ended(process)
        with open_run(path, verify=True) as run:
            if len(run) != count or not all(is_frame(run, i) for i in range(count)):
                found.fail("rows were lost")
        found.add("rows all there")
    code, _, said = ended(start([path, "once"], "tests.validation.faults.copying"))
    if code != 0 or sorted(folder.glob(".copied*")):
        found.fail(f"left behind after {kills} kills: {sorted(folder.glob('.copied*'))} {said}")
    return found


def compile_kills(folder: Path, kills: int, seed: int = 3) -> Found:
    """Killed while kernels are compiled into a cache of their own, which must serve afterwards."""
    found = Found("kill -9 during compilation")
    chance = random.Random(seed)
    scene = pushed_scene().replace({"push.stop": "0.02 pi"})
    (folder / "short.toml").write_text(scene.text)
    path, cache = folder / "compiled.h5", folder / "cache"
    cache.mkdir(mode=0o700)
    words = ["push", folder / "short.toml", "-o", path, "--quiet"]
    for _ in range(kills):
        process = start(words, XDG_CACHE_HOME=str(cache), NUMBA_CACHE_DIR="")
        time.sleep(chance.uniform(1.0, 12.0))
        process.kill()
        ended(process)
        rows_of(path, found)
        found.add("before the first row" if not path.exists() or not rows_of(path, found) else
                  "among rows")  # fmt: skip
        if path.exists():
            words = ["push", "--resume", path, "--quiet"]
    code, _, said = command(*words, XDG_CACHE_HOME=str(cache))
    if code != 0:
        found.fail(f"with the cache of the killed: {code}: {said}")
    left = [entry.name for entry in folder.iterdir() if entry.name.startswith(".compiled")]
    if left:
        found.fail(f"left behind: {left}")
    return found


def full_disks(folder: Path, trials: int, seed: int = 4) -> Found:
    """Whole pushes in children on a limit of a file's size: the run says what is safe."""
    found = Found("full disk (limit of a file's size) under `push`")
    chance = random.Random(seed)
    scene = coil(edges=24).replace({"push.max_step": "0.0005 pi"})
    (folder / "full.toml").write_text(scene.text)
    for number in range(trials):
        path = folder / f"full-{number}.h5"
        limit = chance.randint(10_000, 900_000)
        process = start([limit, folder / "full.toml", path], "tests.validation.faults.limited")
        code, _, said = ended(process)
        if code != 3 or said.count("\n") != 1:
            found.fail(f"limit {limit}: exit code {code}: {said[-300:]}")
        if path.exists():
            with open_run(path, verify=True) as run:
                if f"; {len(run)} frames are safe" not in said:
                    found.fail(f"{len(run)} rows, but: {said}")
                found.add("rows safe, as said" if len(run) else "no row, as said")
        else:
            found.add("no file, as said")
        if list(folder.glob(f".full-{number}*")):
            found.fail("left behind")
    return found


def limit_files(size: int) -> None:
    """Let no file of this process grow beyond ``size`` bytes."""
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, size))
