"""Signals at every phase: one line, the exit code 128 + n, and an ending in the file."""

from __future__ import annotations

import random
import signal
import time
from pathlib import Path

from derod.pushing.frames import Outcome
from derod.record import open_run
from tests.validation.faults.rivals import long_scene, rows
from tests.validation.faults.trial import Found, ended, start, wait_until

NUMBERS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
BEGUN = 0.35  # s, until Python itself has started and derod hears signals


def judge(found: Found, phase: str, path: Path, number: int, code: int, said: str) -> None:
    """Look at a process that was sent a signal."""
    if code == 0:
        found.add("it had ended")
        return
    if code != 128 + number or said.count("\n") != 1 or "interrupted" not in said:
        found.fail(f"{phase}, {signal.Signals(number).name}: {code}: {said[-500:]!r}")
    found.add(phase)
    if not path.exists():
        return
    with open_run(path, verify=True) as run:
        ending = run.ending
        if ending is None or ending.outcome is not Outcome.INTERRUPTED or "nan" in ending.message:
            found.fail(f"{phase}: {len(run)} rows, {ending}")


def signals(folder: Path, trials: int) -> Found:
    """One signal, at any moment of start-up, compilation (with a cache of its own) or push."""
    found, chance = Found("a signal to `push` (INT, TERM, HUP)"), random.Random(41)
    (folder / "scene.toml").write_text(long_scene().text)
    for trial in range(trials):
        phase = ("start-up", "compilation", "push")[trial % 3]
        path = folder / f"{trial}.h5"
        _send(found, folder, path, phase, chance, 1)
    return found


def storms(folder: Path, trials: int) -> Found:
    """Twenty signals of all kinds within a fifth of a second."""
    found, chance = Found("storms of 20 signals"), random.Random(42)
    (folder / "scene.toml").write_text(long_scene().text)
    for trial in range(trials):
        phase = ("compilation", "push")[trial % 2]
        _send(found, folder, folder / f"storm-{trial}.h5", phase, chance, 20)
    return found


def _send(
    found: Found, folder: Path, path: Path, phase: str, chance: random.Random, count: int
) -> None:
    changes = {}
    if phase == "compilation":
        cache = folder / f"cache-{path.stem}"
        cache.mkdir(mode=0o700)
        changes = {"XDG_CACHE_HOME": str(cache)}
    words = ["push", folder / "scene.toml", "-o", path, "--quiet"]
    process = start(words, **changes)
    if phase == "start-up":
        time.sleep(chance.uniform(BEGUN, 1.5))
    elif phase == "compilation":
        wait_until(lambda: any(cache.rglob("*.claim")) or process.poll() is not None, 30.0)
        time.sleep(chance.uniform(0.2, 8.0))
    else:
        wait_until(lambda: rows(path) > 2 or process.poll() is not None, 60.0)
        time.sleep(chance.uniform(0.0, 0.5))
    numbers = [chance.choice(NUMBERS) for _ in range(count)]
    for number in numbers:
        if process.poll() is None:
            process.send_signal(number)
            time.sleep(0.01 if count > 1 else 0.0)
    began = time.monotonic()
    code, _, said = ended(process, 120.0)
    judge(found, phase, path, code - 128 if code - 128 in numbers else numbers[0], code, said)
    found.slowest = max(found.slowest, time.monotonic() - began)
