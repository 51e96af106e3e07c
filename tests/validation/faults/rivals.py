"""Two processes that want to write one run: one wins, the other is told by whom."""

from __future__ import annotations

import random
import re
import shutil
import subprocess
import time
from pathlib import Path

import derod
from derod.pushing.frames import Outcome
from derod.record import open_run
from tests.scenes import coil
from tests.validation.faults.kills import is_the_same
from tests.validation.faults.trial import Found, ended, start, wait_until


def long_scene() -> derod.Scene:
    """Some 1500 rows: long enough to be met by a second process."""
    return coil(edges=24, stop='"0.15 pi"').replace({"push.max_step": "0.0001 pi"})


def rows(path: Path) -> int:
    """Committed rows, 0 where there is no file yet."""
    if not path.exists():
        return 0
    with open_run(path) as run:
        return len(run)


def judge(
    found: Found, path: Path, both: list[subprocess.Popen[str]], whole: derod.record.BaseRun
) -> None:
    """Look at how two processes ended, and at their file."""
    began = time.monotonic()
    ends = [(process.pid, *ended(process)) for process in both]
    codes = sorted(code for _, code, _, _ in ends)
    winner = next((pid for pid, code, _, _ in ends if code == 0), None)
    loser = next((said for _, code, _, said in ends if code != 0), "")
    told = re.search(r"is being written by process ([0-9]+)", loser)
    if codes == [0, 3] and told and int(told[1]) == winner and loser.count("\n") == 1:
        found.add("one winner, the other told by whom", time.monotonic() - began)
    elif codes == [0, 2] and "exists already" in loser:
        found.add("one winner, which had ended", time.monotonic() - began)
    else:
        found.add("otherwise")
        found.fail(f"{ends}")
    with open_run(path, verify=True) as run:
        if not is_the_same(run, whole):
            found.fail(f"{len(run)} rows, {run.outcome}: not those of a single push")
    left = [entry.name for entry in path.parent.iterdir() if entry.name.startswith(f".{path.name}")]
    if left:
        found.fail(f"left behind: {left}")


def _prepared(folder: Path) -> tuple[Path, derod.record.BaseRun]:
    scene = long_scene()
    (folder / "scene.toml").write_text(scene.text)
    return folder / "scene.toml", derod.push(scene)


def two_writers(folder: Path, trials: int) -> Found:
    """Two pushes into one new file, begun at once."""
    found = Found("two writers")
    scene, whole = _prepared(folder)
    for number in range(trials):
        path = folder / f"{number}.h5"
        both = [start(["push", scene, "-o", path, "--quiet"]) for _ in range(2)]
        judge(found, path, both, whole)
    return found


def writer_and_resumer(folder: Path, trials: int) -> Found:
    """A resume of a push that is under way."""
    found, chance = Found("writer and resumer"), random.Random(31)
    scene, whole = _prepared(folder)
    for number in range(trials):
        path = folder / f"{number}.h5"
        writer = start(["push", scene, "-o", path, "--quiet"])
        wait_until(lambda path=path: rows(path) > 0, 60.0)
        time.sleep(chance.uniform(0.0, 0.1))
        # stopped while the other starts, so that they do meet; it goes on then
        writer.send_signal(19)
        other = start(["push", "--resume", path, "--quiet"])
        wait_until(lambda other=other: other.poll() is not None, 5.0)
        writer.send_signal(18)
        judge(found, path, [writer, other], whole)
    return found


def two_resumers(folder: Path, trials: int) -> Found:
    """Two resumes of one killed run, begun at once."""
    found = Found("two resumers")
    scene, whole = _prepared(folder)
    killed = folder / "killed.h5"
    writer = start(["push", scene, "-o", killed, "--quiet"])
    wait_until(lambda: rows(killed) > 20, 60.0)
    writer.kill()
    ended(writer)
    with open_run(killed) as run:
        if run.outcome is not None:
            found.fail(f"the run to resume had ended: {Outcome(run.outcome)}")
    for number in range(trials):
        path = folder / f"{number}.h5"
        shutil.copyfile(killed, path)
        both = [start(["push", "--resume", path, "--quiet"]) for _ in range(2)]
        judge(found, path, both, whole)
    return found
