"""A full disk, a folder that vanishes: a clear error and a file that can be read."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

import derod.pushing.driver
from derod import push
from derod.errors import InUseError, RecordError
from derod.pushing.frames import Frame, Outcome
from derod.record import RunWriter, growing, open_run, resume_copy
from tests.synthetic import drive, is_frame, make_event, make_frame, small_scene

ROOT = Path(__file__).parent.parent.parent


@pytest.fixture
def synthetic(monkeypatch: pytest.MonkeyPatch) -> None:
    """``derod.push`` without physics."""
    monkeypatch.setattr(derod.pushing.driver, "drive", drive)


def begun(path: Path, count: int = 3) -> RunWriter:
    writer = RunWriter(path)
    writer.start(small_scene(), 0)
    for i in range(count):
        writer.frame(make_frame(i, 24))
    return writer


@pytest.mark.parametrize("size", [300_000, 333_333, 400_000, 700_001, 1_500_000])
def test_a_full_disk(tmp_path: Path, size: int) -> None:
    path = tmp_path / "run.h5"
    done = subprocess.run(
        [sys.executable, "-m", "tests.record.fill_disk", str(path), str(size)],
        cwd=ROOT,
        capture_output=True,
        text=True,
        timeout=60,
    )
    assert done.returncode == 0, done.stderr
    count, message = done.stdout.splitlines()
    assert message == f"{path}: file too large; {count} frames are safe"
    with open_run(path) as run:
        assert len(run) == int(count) > 0
        assert all(is_frame(run, i) for i in range(len(run)))
        assert run.ending is not None and run.ending.outcome is Outcome.RECORD_FAILED
        assert f"{count} frames are safe" in run.ending.message
    resume_copy(path)  # with room again, it goes on


def test_no_room_even_for_the_first_frame(tmp_path: Path) -> None:
    path = tmp_path / "run.h5"
    done = subprocess.run(
        [sys.executable, "-m", "tests.record.fill_disk", str(path), "20000"],
        cwd=ROOT,
        capture_output=True,
        text=True,
        timeout=60,
    )
    assert done.returncode == 0, done.stderr
    count, message = done.stdout.splitlines()
    assert count == "0" and message == f"{path}: cannot be written: file too large"
    assert list(tmp_path.iterdir()) == [], "nothing half-made is left behind"


def test_a_write_that_fails_inside_hdf5(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "run.h5"
    writer = begun(path)

    def fail(self: object, i: int, value: object) -> None:
        raise OSError("Can't write data (file write failed: errno = 28, error message = '...')")

    with monkeypatch.context() as patch:
        patch.setattr(growing.Column, "write", fail)
        with pytest.raises(RecordError, match="no space left on device; 3 frames are safe"):
            writer.frame(make_frame(3, 24))
    with pytest.raises(RecordError, match="not open"):
        writer.event(make_event(3))
    with open_run(path) as run:
        assert len(run) == 3 and all(is_frame(run, i) for i in range(3))


def test_a_folder_that_vanishes(tmp_path: Path) -> None:
    folder = tmp_path / "folder"
    writer = begun(folder / "run.h5")
    shutil.rmtree(folder)
    with pytest.raises(RecordError, match=r"the file is gone.*with 3 frames; 0 frames are safe"):
        writer.frame(make_frame(3, 24))


def test_a_folder_that_is_renamed(tmp_path: Path) -> None:
    writer = begun(tmp_path / "one" / "run.h5")
    (tmp_path / "one").rename(tmp_path / "two")
    with pytest.raises(RecordError, match="the file is gone"):
        writer.event(make_event(3))
    with open_run(tmp_path / "two" / "run.h5") as run:
        assert len(run) == 3 and is_frame(run, 2)
        assert run.outcome is Outcome.RECORD_FAILED


def test_a_file_that_is_replaced(tmp_path: Path) -> None:
    path, other = tmp_path / "run.h5", tmp_path / "other.h5"
    writer = begun(path)
    with pytest.raises(InUseError, match=f"is being written by process {os.getpid()}"):
        drive(small_scene(), [RunWriter(path, overwrite=True)])
    drive(small_scene(), [RunWriter(other)])
    other.replace(path)
    with pytest.raises(RecordError, match=r"the file is gone.*with 3 frames; 0 frames are safe"):
        writer.frame(make_frame(3, 24))
    with open_run(path) as run:
        assert len(run) == 40, "the other's file is left alone"


@pytest.mark.usefixtures("synthetic")
def test_a_push_whose_folder_vanishes(tmp_path: Path) -> None:
    folder = tmp_path / "folder"
    heard = []

    class Vandal:
        def start(self, *_: object) -> None: ...
        def event(self, _: object) -> None: ...

        def frame(self, frame: Frame) -> None:
            if frame.row["increment"] == 7:
                folder.rename(tmp_path / "elsewhere")

        def finish(self, ending: object) -> None:
            heard.append(ending)

    with pytest.raises(RecordError, match="with 8 frames; 0 frames are safe"):
        push(small_scene(), folder / "run.h5", [Vandal()])
    (ending,) = heard
    assert ending.outcome is Outcome.RECORD_FAILED
    with open_run(tmp_path / "elsewhere" / "run.h5") as run:
        assert len(run) == 8 and run.outcome is Outcome.RECORD_FAILED


@pytest.mark.usefixtures("synthetic")
def test_an_observer_that_raises_is_left_out(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "run.h5"
    told: list[str] = []

    class Broken:
        def start(self, *_: object) -> None: ...
        def event(self, _: object) -> None: ...

        def finish(self, _: object) -> None:
            told.append("finish")

        def frame(self, frame: Frame) -> None:
            told.append("frame")
            if frame.row["increment"] == 3:
                raise ZeroDivisionError("on purpose")

    class Meddler(Broken):
        def frame(self, frame: Frame) -> None:
            frame.row["end_tension"] = -1.0
            frame.positions[:] = 0.0

    push(small_scene(), path, [Broken(), Meddler()])
    with open_run(path, verify=True) as run:
        assert len(run) == 40 and run.outcome is Outcome.COMPLETED
        assert all(is_frame(run, i) for i in range(40))
    assert told == ["frame"] * 4 + ["finish"] * 2
    errors = capsys.readouterr().err.splitlines()
    assert len(errors) == 2
    assert "Broken.frame failed with ZeroDivisionError: on purpose; the push goes on" in errors[1]
    assert "Meddler.frame failed with ValueError" in errors[0]


@pytest.fixture
def sealed(tmp_path: Path) -> Iterator[Path]:
    folder = tmp_path / "sealed"
    folder.mkdir()
    folder.chmod(0o500)
    yield folder
    folder.chmod(0o700)


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write anywhere")
def test_a_folder_that_may_not_be_written(sealed: Path) -> None:
    with pytest.raises(RecordError, match="cannot be written: permission denied"):
        RunWriter(sealed / "run.h5").start(small_scene(), 0)


def test_a_path_through_a_file(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    with pytest.raises(RecordError, match="cannot be written"):
        RunWriter(tmp_path / "file" / "run.h5").start(small_scene(), 0)
    with pytest.raises(RecordError, match="cannot be written"):
        RunWriter(tmp_path, overwrite=True).start(small_scene(), 0)
    assert not list(tmp_path.parent.glob("*.part")), "no scraps"
    assert not list(tmp_path.parent.glob(".*.part"))
