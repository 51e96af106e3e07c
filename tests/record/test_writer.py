"""Run files: what is written comes back, also after kills, full disks and vanished folders."""

from __future__ import annotations

import random
import shutil
import subprocess
import sys
import time
from pathlib import Path

import h5py
import numpy as np
import pytest

from derod.errors import RecordError
from derod.pushing.frames import Ending, Outcome
from derod.pushing.rows import ROW
from derod.record import Run, RunWriter, layout, open_run, resume_copy
from tests.synthetic import is_frame, make_event, make_frame, small_scene

ROOT = Path(__file__).parents[2]
DONE = Ending(Outcome.COMPLETED, "reached ½", 0.5)
EDGES = small_scene().mesh.edges


def written(path: Path, frames: int, *, ended: bool = True) -> RunWriter:
    """A file with ``frames`` frames, and an event before frames 3, 10, 17, ..."""
    writer = RunWriter(path)
    writer.start(small_scene(), 0)
    go_on(writer, 0, frames)
    if ended:
        writer.finish(DONE)
    return writer


def go_on(writer: RunWriter, first: int, frames: int) -> None:
    for i in range(first, frames):
        if i % 7 == 3:
            writer.event(make_event(i))
        writer.frame(make_frame(i, EDGES))


def events_before(frames: int) -> list[int]:
    return [i for i in range(frames) if i % 7 == 3]


def writing(path: Path, frames: int, *limit: int) -> subprocess.Popen[str]:
    """A process that writes; see tests/record/writing.py."""
    command = [sys.executable, "-m", "tests.record.writing", str(path), str(frames)]
    return subprocess.Popen(
        command + [str(number) for number in limit],
        cwd=ROOT,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )


def reported(process: subprocess.Popen[str], frames: int) -> None:
    """Wait until the process says it has committed so many frames."""
    assert process.stdout is not None
    for line in process.stdout:
        if int(line) >= frames:
            return
    raise AssertionError(f"the writer ended before frame {frames}")


def test_what_is_written_comes_back(tmp_path: Path) -> None:
    path = tmp_path / "made" / "on" / "the" / "way" / "run.h5"
    written(path, 20)
    with open_run(path) as run:
        assert len(run) == 20
        assert run.table.dtype == ROW
        assert all(is_frame(run, i) for i in range(20))
        assert np.array_equal(run.positions(-1), run.positions(19))
        assert run.scene == small_scene()
        assert list(run.events) == [make_event(i) for i in (3, 10, 17)]
        assert run.ending == DONE
        assert run.outcome is Outcome.COMPLETED
        assert {"derod", "numpy", "numba", "h5py", "python", "seed"} <= set(run.versions)
        for i in (20, -21):
            with pytest.raises(IndexError):
                run.positions(i)
        with pytest.raises(ValueError, match="read-only"):
            run.table["end_tension"][0] = 1.0
    assert list(path.parent.iterdir()) == [path], "no passing file is left"


def test_a_finished_file_is_plain_hdf5_with_units(tmp_path: Path) -> None:
    written(tmp_path / "run.h5", 3)
    frame_bytes = 8 * (5 * EDGES + 7) + ROW.itemsize
    with h5py.File(tmp_path / "run.h5", "r") as file:
        position = file["particles/rod/position"]
        assert position["value"].shape == (3, EDGES + 1, 3)
        assert position["value"].chunks == (1, EDGES + 1, 3)
        assert position["value"].attrs["unit"] == b"D"
        assert list(position["step"]) == [0, 1, 2]
        assert position["step"] == file["observables/push/step"], "one dataset, linked"
        assert file["particles/rod/box"].attrs["dimension"] == 3
        assert tuple(file["h5md"].attrs["version"]) == (1, 1)
        units = file["observables/push/value"].attrs
        assert units["unit end_tension"] == b"K0 D-2"
        assert "capillary_force = 20.0" in file["parameters/scene"][()].decode()
    spare = (tmp_path / "run.h5").stat().st_size - 3 * frame_bytes
    assert spare < 100_000, "room taken and not used is given back"


def test_every_unit_belongs_to_a_field() -> None:
    assert set(layout.ROW_UNITS) <= set(ROW.names or ())


def test_long_messages_are_cut_between_characters() -> None:
    assert layout.decoded(layout.encoded("é" * 600, 1023)) == "é" * 511


def test_an_existing_file_is_kept_unless_told_otherwise(tmp_path: Path) -> None:
    path = tmp_path / "run.h5"
    written(path, 2)
    with pytest.raises(RecordError, match="exists already"):
        RunWriter(path).start(small_scene(), 0)
    assert len(open_run(path)) == 2
    writer = RunWriter(path, overwrite=True)
    writer.start(small_scene(), 0)
    writer.finish(DONE)
    assert len(open_run(path)) == 0


def test_frames_that_do_not_fit_are_refused(tmp_path: Path) -> None:
    writer = written(tmp_path / "run.h5", 2, ended=False)
    with pytest.raises(RecordError, match="positions has shape"):
        writer.frame(make_frame(2, EDGES + 1))
    with pytest.raises(RecordError, match="increment 5 follows frame 1"):
        writer.frame(make_frame(5, EDGES))
    writer.frame(make_frame(2, EDGES))
    writer.finish(DONE)
    writer.finish(DONE)  # once more does nothing
    with pytest.raises(RecordError, match="not open"):
        writer.frame(make_frame(3, EDGES))
    assert len(open_run(tmp_path / "run.h5")) == 3


@pytest.mark.parametrize("seed", range(6))
def test_a_killed_run_keeps_every_committed_frame_and_goes_on(tmp_path: Path, seed: int) -> None:
    path = tmp_path / "run.h5"
    chance = random.Random(seed)
    process = writing(path, 100_000)
    reported(process, chance.randint(1, 120))
    time.sleep(chance.random() * 0.02)
    process.kill()
    last = [int(line) for line in process.communicate()[0].split()[-1:]]
    with open_run(path) as run:
        count = len(run)
        assert count >= (last[0] if last else 1)
        assert run.ending is None
        assert all(is_frame(run, i) for i in range(count))
    writer = resume_copy(path)
    writer.start(small_scene(), count)
    go_on(writer, count, count + 5)
    writer.finish(DONE)
    with open_run(path) as run:
        assert len(run) == count + 5
        assert all(is_frame(run, i) for i in range(count + 5))
        assert [event.increment for event in run.events] == events_before(count + 5)
        assert run.ending == DONE
    assert list(tmp_path.iterdir()) == [path]


def test_a_live_run_can_be_read(tmp_path: Path) -> None:
    path = tmp_path / "run.h5"
    process = writing(path, 100_000)
    try:
        reported(process, 5)
        with open_run(path) as run:
            seen = len(run)
            assert seen >= 5
            for _ in range(10):
                reported(process, seen + 3)
                run.refresh()
                assert len(run) >= seen + 3
                assert run.ending is None
                newest = range(max(seen, len(run) - 20), len(run))  # a writer outruns who reads all
                assert all(is_frame(run, i) for i in newest)
                seen = len(run)
    finally:
        process.kill()
        process.communicate()


def test_a_reader_follows_a_run_to_its_end_and_beyond(tmp_path: Path) -> None:
    path = tmp_path / "run.h5"
    process = writing(path, 30)
    reported(process, 3)
    with open_run(path) as run:
        assert process.wait(30) == 0
        process.communicate()
        assert run.refresh().ending is not None
        writer = resume_copy(path)
        writer.start(small_scene(), 30)
        writer.frame(make_frame(30, EDGES))
        writer.finish(DONE)
        assert len(run) == 30, "what was read stays until refreshed"
        assert len(run.refresh()) == 31
        assert is_frame(run, 30)


@pytest.mark.parametrize("limit", [150_000, 400_000, 700_001])
def test_a_full_disk_ends_the_run_and_leaves_it_readable(tmp_path: Path, limit: int) -> None:
    path = tmp_path / "run.h5"
    process = writing(path, 100_000, limit)
    output, errors = process.communicate(timeout=60)
    assert process.returncode == 3, errors
    assert "file too large" in errors
    assert "Traceback" not in errors
    with open_run(path) as run:
        assert len(run) == len(output.split())
        assert all(is_frame(run, i) for i in range(len(run)))
        assert run.outcome is Outcome.RECORD_FAILED
        assert "file too large" in run.ending.message  # type: ignore[union-attr]


def test_a_write_that_fails_inside_hdf5_leaves_the_frames(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "run.h5"
    writer = written(path, 12, ended=False)

    def fail(*_: object) -> None:
        raise RuntimeError("Unable to flush (file write failed: errno = 5, error message = ...)")

    monkeypatch.setattr("derod.record.column.Column.flush", fail)
    with pytest.raises(RecordError, match=r"input/output error; 12 frames are safe"):
        writer.frame(make_frame(12, EDGES))
    with open_run(path) as run:
        assert len(run) == 12
        assert all(is_frame(run, i) for i in range(12))
        assert run.outcome is Outcome.RECORD_FAILED


def test_a_vanished_folder_is_noticed(tmp_path: Path) -> None:
    folder = tmp_path / "out"
    writer = written(folder / "run.h5", 4, ended=False)
    shutil.rmtree(folder)
    with pytest.raises(RecordError, match="the file is gone"):
        writer.frame(make_frame(4, EDGES))


def test_a_moved_folder_is_noticed_and_its_file_readable(tmp_path: Path) -> None:
    writer = written(tmp_path / "out" / "run.h5", 4, ended=False)
    (tmp_path / "out").rename(tmp_path / "elsewhere")
    with pytest.raises(RecordError, match="the file is gone"):
        writer.frame(make_frame(4, EDGES))
    with open_run(tmp_path / "elsewhere" / "run.h5") as run:
        assert len(run) == 4
        assert run.outcome is Outcome.RECORD_FAILED


def test_a_file_that_is_written_is_left_to_its_writer(tmp_path: Path) -> None:
    path = tmp_path / "run.h5"
    first = written(path, 4, ended=False)
    for begin in (lambda: resume_copy(path), lambda: written(path, 1)):
        with pytest.raises(RecordError, match="is being written by process"):
            begin()
    first.frame(make_frame(4, EDGES))
    first.finish(DONE)
    second = resume_copy(path)
    second.start(small_scene(), 5)
    second.finish(DONE)
    assert len(open_run(path, verify=True)) == 5


def test_places_that_cannot_be_written(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(RecordError, match="cannot be written"):
        RunWriter(tmp_path / "file" / "run.h5").start(small_scene(), 0)
    with pytest.raises(RecordError, match="cannot be written"):
        RunWriter("/proc/run.h5").start(small_scene(), 0)


def test_resuming_drops_events_of_frames_that_never_came(tmp_path: Path) -> None:
    path = tmp_path / "run.h5"
    writer = written(path, 10, ended=False)
    writer.event(make_event(10))
    writer.finish(Ending(Outcome.NOT_CONVERGED, "stuck", 0.1))
    assert [event.increment for event in open_run(path).events] == [3, 10]
    copy = resume_copy(path)
    copy.start(small_scene(), 10)
    copy.finish(DONE)
    assert [event.increment for event in open_run(path).events] == [3]


def test_resuming_keeps_what_it_must(tmp_path: Path) -> None:
    path = tmp_path / "run.h5"
    written(path, 5)
    created = open_run(path).created
    longer = small_scene(push__stop="0.5 pi")
    writer = resume_copy(path, longer)
    with pytest.raises(RecordError, match="has 5 frames"):
        writer.start(longer, 4)
    writer.start(longer, 5)
    writer.finish(DONE)
    with open_run(path) as run:
        assert run.scene == longer
        assert run.created == created
    with pytest.raises(RecordError, match="another mesh"):
        resume_copy(path, small_scene(mesh__edges=30))
    assert list(tmp_path.iterdir()) == [path]


def test_what_is_no_run_file(tmp_path: Path) -> None:
    with pytest.raises(RecordError, match="no such file"):
        open_run(tmp_path / "missing.h5")
    with pytest.raises(RecordError, match="no such file"):
        open_run(tmp_path)
    (tmp_path / "text.h5").write_text("not HDF5")
    with pytest.raises(RecordError, match="cannot be read"):
        Run(tmp_path / "text.h5")
    with h5py.File(tmp_path / "other.h5", "w") as file:
        file["x"] = 1
    with pytest.raises(RecordError, match="not a run file"):
        Run(tmp_path / "other.h5")
    written(tmp_path / "newer.h5", 1)
    with h5py.File(tmp_path / "newer.h5", "r+") as file:
        file.attrs["derod_format"] = layout.FORMAT + 1
    with pytest.raises(RecordError, match="newer derod"):
        Run(tmp_path / "newer.h5")
