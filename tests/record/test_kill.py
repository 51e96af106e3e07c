"""A writer killed with SIGKILL: the file opens, and what was committed is what was written."""

from __future__ import annotations

import os
import random
import shutil
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest

import derod
from derod.pushing.frames import Outcome
from derod.record import open_run, resume_copy
from tests.scenes import coil
from tests.synthetic import drive, is_frame, make_event, make_frame, small_scene

ROOT = Path(__file__).parent.parent.parent
MOMENTS = random.Random(7)
PATIENCE = 300.0  # s, for kernels compiled on a busy machine


@contextmanager
def python(*arguments: object) -> Iterator[subprocess.Popen[str]]:
    """A Python process of its own, gone at the end."""
    process = subprocess.Popen(
        [sys.executable, *map(str, arguments)],
        cwd=ROOT,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        text=True,
        env={**os.environ, "OMP_NUM_THREADS": "1"},
    )
    try:
        yield process
    finally:
        process.kill()
        process.communicate()


def check_whole(path: Path) -> int:
    """Assert that all that is committed is as it was written; return the number of frames."""
    with open_run(path) as run:
        assert run.scene == small_scene()
        assert list(run.table["increment"]) == list(range(len(run)))
        assert run.ending is None and run.outcome is None
        for i in range(len(run)):
            assert is_frame(run, i), i
        wanted = [make_event(i) for i in range(4, len(run) + 1, 5)]
        if wanted and wanted[-1].increment == len(run):  # its frame was never written
            assert list(run.events) in (wanted, wanted[:-1])
        else:
            assert list(run.events) == wanted
        return len(run)


@pytest.fixture(scope="module")
def killed(tmp_path_factory: pytest.TempPathFactory) -> list[Path]:
    """Files of writers killed at random moments."""
    folder = tmp_path_factory.mktemp("killed")
    paths = [folder / f"run{i}.h5" for i in range(6)]
    for path in paths:
        with python("-m", "tests.record.keep_writing", path) as process:
            assert process.stdout is not None
            assert process.stdout.readline() == "started\n"
            time.sleep(MOMENTS.uniform(0.0, 0.3))
            assert process.poll() is None, "it writes until it is killed"
    return paths


def test_every_committed_row_is_intact(killed: list[Path]) -> None:
    assert max([check_whole(path) for path in killed]) > 10


def test_a_killed_file_is_copied_and_goes_on(killed: list[Path], tmp_path: Path) -> None:
    path = tmp_path / "run.h5"
    shutil.copy(killed[0], path)
    shutil.copystat(killed[0], path)
    count = check_whole(path)
    writer = resume_copy(path)
    assert check_whole(path) == count
    writer.start(small_scene(), count)
    for i in range(count, count + 3):
        writer.frame(make_frame(i, 24))
    with open_run(path) as run:
        assert len(run) == count + 3
        assert all(is_frame(run, i) for i in range(len(run)))
        assert all(event.increment < count for event in run.events)
    writer.finish(drive(small_scene(), []))
    with open_run(path) as run:
        assert run.outcome is Outcome.COMPLETED and len(run) == count + 3
    assert [entry.name for entry in tmp_path.iterdir()] == ["run.h5"]


def test_a_killed_push_resumes_to_the_uninterrupted_table(tmp_path: Path) -> None:
    """The whole program: a push killed with -9 after some rows, then ``derod push --resume``."""
    pushed = coil().replace({"push.max_step": "0.002 pi"})  # enough rows to be killed among them
    whole = derod.push(pushed)
    scene, path = tmp_path / "scene.toml", tmp_path / "run.h5"
    scene.write_text(pushed.text)
    with python("-m", "derod", "push", scene, "-o", path, "--quiet") as process:
        wait_for_rows(path, 6, process)
    with open_run(path) as run:
        cut = len(run)
        assert 6 <= cut < len(whole) and run.ending is None
    command = [sys.executable, "-m", "derod", "push", "--resume", path, "--quiet"]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, timeout=PATIENCE)
    assert done.returncode == 0, done.stderr
    with open_run(path) as run:
        assert run.outcome is Outcome.COMPLETED
        assert len(run) == len(whole)
        for name in whole.table.dtype.names or ():
            if name != "wall_time":
                np.testing.assert_array_equal(run.table[name], whole.table[name], err_msg=name)
        assert (np.diff(run.table["wall_time"]) > 0).all()
        for i in range(len(whole)):
            np.testing.assert_array_equal(run.positions(i), whole.positions(i))
            np.testing.assert_array_equal(run.edge_tension(i), whole.edge_tension(i))
        assert [e.message for e in run.events] == [e.message for e in whole.events]


def wait_for_rows(path: Path, count: int, process: subprocess.Popen[str]) -> None:
    """Wait until ``path`` has ``count`` committed rows."""
    end = time.monotonic() + PATIENCE
    while time.monotonic() < end:
        if path.exists():
            with open_run(path) as run:
                if len(run) >= count:
                    return
        assert process.poll() is None, "it ended by itself"
        time.sleep(0.005)
    raise AssertionError("too few rows in time")
