"""Outputs that are closed, full or broken, and outputs that must not be written, for every command."""

from __future__ import annotations

import contextlib
import os
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import derod
from derod.pushing.frames import Outcome
from derod.record import open_run
from tests.scenes import coil
from tests.validation.faults.trial import PATIENCE, ROOT, Found, environment

NOT_SHOWN = 4
WAYS = ("closed", "broken", "full")


@contextlib.contextmanager
def stream(way: str) -> Iterator[int]:
    """A descriptor nobody reads any more, or one with no room left (a full pipe: no device)."""
    reader, writer = os.pipe()
    if way == "full":
        os.set_blocking(writer, False)
        with contextlib.suppress(BlockingIOError):
            while True:
                os.write(writer, b"x" * 4096)
    else:
        os.close(reader)
    try:
        yield writer
    finally:
        os.close(writer)
        if way == "full":
            os.close(reader)


def run(words: list[Any], way: str, which: str) -> tuple[int, str]:
    """A command with its standard output or error, or both, closed, broken or full."""
    numbers = {"out": (1,), "err": (2,), "both": (1, 2)}[which]

    def close() -> None:
        for number in numbers:
            os.close(number)

    kept = subprocess.PIPE
    with stream(way) as bad:
        done = subprocess.run(
            [sys.executable, "-m", "derod", *map(str, words)],
            cwd=ROOT,
            env=environment(),
            stdin=subprocess.DEVNULL,
            stdout=bad if 1 in numbers and way != "closed" else kept,
            stderr=bad if 2 in numbers and way != "closed" else kept,
            preexec_fn=close if way == "closed" else None,
            timeout=PATIENCE,
            check=False,
        )
    return done.returncode, (done.stderr or b"").decode()


def prepared(folder: Path) -> tuple[Path, Path, Path]:
    """A scene, a finished run of it, and a branch file of another rod's first path."""
    scene = folder / "scene.toml"
    scene.write_text(coil(edges=24, stop='"0.05 pi"').text)
    derod.push(derod.load_scene(scene), folder / "run.h5").close()
    branches = folder / "branches.h5"
    done = subprocess.run(
        [sys.executable, "-m", "derod", "branch", scene, "-o", branches, "--paths", "Ax",
         "--max-step", "0.5", "--no-stability", "--quiet"],
        cwd=ROOT, env=environment(), capture_output=True, check=False, timeout=PATIENCE,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    return scene, folder / "run.h5", branches


def is_complete(path: Path) -> bool:
    """Whether a push came to its end."""
    with open_run(path, verify=True) as opened:
        return opened.outcome is Outcome.COMPLETED


def broken_outputs(folder: Path, trials: int) -> Found:
    """Every command x closed, broken and full x standard output, error and both."""
    found = Found("closed, broken and full outputs x commands")
    scene, finished, branches = prepared(folder)
    made = folder / "made.h5"
    # the words, the exit code with all streams in order, whether results are printed, what is made
    commands: list[tuple[list[Any], int, bool, Callable[[], bool]]] = [
        (["--help"], 0, True, lambda: True),
        (["check", scene], 0, True, lambda: True),
        (["info", "--verify", finished], 0, True, lambda: True),
        (["compare", finished, branches, "--tolerance", "1e-9"], 1, True, lambda: True),
        (["compare", finished, branches, "--tolerance", "0.9"], 0, True, lambda: True),
        (["branch", branches, "--export", "auto"], 0, True, lambda: True),
        (["push", scene, "-o", made, "--force"], 0, False, lambda: is_complete(made)),
        (["push", "--resume", finished], 0, False, lambda: is_complete(finished)),
        (["view", finished, "--save", folder / "a.rrd", "--force"], 0, False,
         lambda: (folder / "a.rrd").stat().st_size > 0),
        (["branch", scene, "-o", folder / "b.h5", "--force", "--paths", "Ax", "--max-step", "0.5",
          "--no-stability"], 0, False, lambda: bool(derod.open_branches(folder / "b.h5").complete)),
    ]  # fmt: skip
    for words, right, printed, is_made in commands:
        for way in WAYS:
            for which in ("out", "err", "both"):
                began = time.monotonic()
                code, said = run(words, way, which)
                wanted = (right or NOT_SHOWN) if printed and which != "err" else right
                name = f"{words[0]} {words[1] if words[0] == 'push' else ''}, {which} {way}"
                if code != wanted or "Traceback" in said or "Exception ignored" in said:
                    found.fail(f"{name}: exit code {code}, not {wanted}: {said[-300:]}")
                if not is_made():
                    found.fail(f"{name}: not done")
                found.add(f"exit code {code}", time.monotonic() - began)
    return found


def refused_outputs(folder: Path, trials: int) -> Found:
    """Every writing command x outputs that must not be written: refused with 2, and left alone."""
    found = Found("outputs that must not be written x commands")
    scene, finished, branches = prepared(folder)
    protected, link, pipe = folder / "protected.h5", folder / "link.h5", folder / "pipe"
    protected.write_text("precious")
    protected.chmod(0o444)
    os.mkfifo(pipe)
    link.symlink_to(scene)
    (folder / "loop").symlink_to(folder / "loop")
    commands: dict[str, list[Any]] = {
        "push": ["push", scene, "--quiet", "-o"],
        "branch": ["branch", scene, "--quiet", "-o"],
        "export": ["branch", branches, "--export", "auto", "-o"],
        "view": ["view", finished, "--save"],
        "rerun": ["push", scene, "-o", folder / "new.h5", "--quiet", "--rerun"],
    }
    inputs = {"push": scene, "branch": scene, "export": branches, "view": finished, "rerun": scene}
    for name, words in commands.items():
        ending = ".rrd" if name in ("view", "rerun") else ""
        places: dict[str, tuple[Path, bool]] = {
            "exists": (finished, False),
            "its input": (inputs[name], True),
            "its input by a link": (link, True),
            "a pipe": (pipe, True),
            "a folder": (folder, True),
            "write-protected": (protected, True),
            "a link in a circle": (folder / "loop", True),
            "in no folder": (scene / "x.h5", True),
        }
        for kind, (place, force) in places.items():
            if kind == "its input by a link":
                link.unlink()
                link.symlink_to(inputs[name])
            if ending:  # rerun files have names of their own: links to the places
                named = folder / f"{name} {kind}.rrd"
                if kind == "in no folder":
                    named = scene / "x.rrd"
                elif not os.path.lexists(named):
                    named.symlink_to(place)
                place = named
            before = contents(folder)
            began = time.monotonic()
            done = subprocess.run(
                [sys.executable, "-m", "derod", *map(str, [*words, place]), *["--force"] * force],
                cwd=ROOT, env=environment(), capture_output=True, text=True, check=False, timeout=60,
            )  # fmt: skip
            seconds = time.monotonic() - began
            right = (2, 3) if kind == "in no folder" else (2,)
            if done.returncode not in right or done.stderr.count("\n") != 1:
                found.fail(f"{name}, {kind}: {done.returncode}: {done.stderr[-300:]}")
            if contents(folder) != before:
                found.fail(f"{name}, {kind}: something was written")
            found.add("refused, nothing written", seconds)
    return found


def contents(folder: Path) -> dict[str, bytes]:
    """Names and contents of the regular files in a folder."""
    return {
        path.name: path.read_bytes() if path.is_file() else b"" for path in sorted(folder.iterdir())
    }
