"""Runs as they are read: by index, while they are written, in memory, and what is no run."""

from __future__ import annotations

from pathlib import Path

import h5py
import numpy as np
import pytest

from derod.errors import RecordError
from derod.pushing.frames import Ending, Outcome
from derod.pushing.rows import ROW
from derod.record import BaseRun, MemoryRun, RunWriter, open_run
from tests.synthetic import drive, is_frame, make_event, make_frame, small_scene

COUNT = 40  # increments of small_scene


@pytest.fixture(params=["file", "memory"])
def run(request: pytest.FixtureRequest, tmp_path: Path) -> BaseRun:
    """The same run, in a file and in memory."""
    if request.param == "memory":
        memory = MemoryRun()
        drive(small_scene(), [memory])
        return memory
    drive(small_scene(), [RunWriter(tmp_path / "run.h5")])
    opened = open_run(tmp_path / "run.h5")
    request.addfinalizer(opened.close)
    return opened


def test_indices(run: BaseRun) -> None:
    assert len(run) == COUNT
    for i, same in [(0, -COUNT), (7, 7 - COUNT), (COUNT - 1, -1), (np.int64(3), 3)]:
        made = make_frame(int(i), 24)
        for j in (i, same):
            np.testing.assert_array_equal(run.positions(j), made.positions)
            np.testing.assert_array_equal(run.arc_length(j), made.arc_length)
            np.testing.assert_array_equal(run.drop_center(j), made.drop_center)
            np.testing.assert_array_equal(run.edge_tension(j), made.edge_tension)
            assert run.frame_at(j).row == run.table[int(i)]
    assert run.positions(0).shape == (25, 3)
    assert run.arc_length(0).shape == (25,)
    assert run.drop_center(0).shape == (3,)
    assert run.edge_tension(0).shape == (24,)


@pytest.mark.parametrize("name", ["positions", "arc_length", "drop_center", "edge_tension"])
@pytest.mark.parametrize("i", [COUNT, -COUNT - 1, 10**6])
def test_increments_that_are_not_there(run: BaseRun, name: str, i: int) -> None:
    with pytest.raises(IndexError, match=f"increment {i} of a run with {COUNT}"):
        getattr(run, name)(i)


def test_the_same_interface(run: BaseRun) -> None:
    assert run.scene == small_scene()
    assert run.table.dtype == ROW and run.table.shape == (COUNT,)
    assert run.table is run.table, "read once"
    with pytest.raises(ValueError, match="read-only"):
        run.table["residual"] = 0.0
    assert run.events == tuple(make_event(i) for i in range(4, COUNT, 5))
    assert run.outcome is Outcome.COMPLETED
    assert run.ending == Ending(Outcome.COMPLETED, "reached 0.4 pi", 0.4 * np.pi)
    assert run.refresh() is run
    positions = run.positions(3)
    positions[:] = 0.0
    np.testing.assert_array_equal(run.positions(3), make_frame(3, 24).positions)
    with run as entered:
        assert entered is run
        assert all(is_frame(run, i) for i in range(COUNT))


def test_a_run_in_memory_keeps_its_own_arrays() -> None:
    memory = MemoryRun()
    with pytest.raises(RecordError, match="not begun"):
        memory.scene  # noqa: B018
    memory.start(small_scene(), 0)
    assert len(memory) == 0 and memory.table.shape == (0,) and memory.table.dtype == ROW
    frame = make_frame(0, 24)
    memory.frame(frame)
    assert len(memory.table) == 1
    frame.positions[:] = -1.0
    frame.drop_center[:] = -1.0
    np.testing.assert_array_equal(memory.positions(0), make_frame(0, 24).positions)
    np.testing.assert_array_equal(memory.drop_center(0), make_frame(0, 24).drop_center)
    assert memory.ending is None and memory.outcome is None
    with pytest.raises(RecordError, match="goes on at increment 5"):
        memory.start(small_scene(), 5)


def test_reading_while_it_is_written(tmp_path: Path) -> None:
    path = tmp_path / "run.h5"
    writer = RunWriter(path)
    writer.start(small_scene(), 0)
    run = open_run(path)
    assert len(run) == 0 and run.table.shape == (0,) and run.events == () and run.ending is None
    with pytest.raises(IndexError):
        run.positions(-1)
    for i in range(20):
        writer.frame(make_frame(i, 24))
        assert len(run) == i, "as it was at the last refresh"
        assert len(run.refresh()) == i + 1
        assert is_frame(run, i)
        np.testing.assert_array_equal(run.positions(-1), make_frame(i, 24).positions)
    assert all(is_frame(run, i) for i in range(20))
    writer.event(make_event(20))
    assert run.events == ()
    assert run.refresh().events == (make_event(20),)
    table = run.table
    writer.finish(Ending(Outcome.INTERRUPTED, "enough", 0.2))
    assert run.ending is None
    assert run.refresh().outcome is Outcome.INTERRUPTED
    run.close()
    assert len(table) == 20, "a table that was read stays"


def test_a_reader_sees_the_file_that_took_the_place(tmp_path: Path) -> None:
    path = tmp_path / "run.h5"
    drive(small_scene(), [RunWriter(path)])
    with open_run(path) as run:
        assert run.scene.noise.seed == 0
        drive(small_scene(push__stop="0.3 pi", noise__seed=5), [RunWriter(path, overwrite=True)])
        assert len(run) == COUNT and is_frame(run, COUNT - 1)
        assert len(run.refresh()) == 30 and run.scene.noise.seed == 5
        path.unlink()
        assert len(run.refresh()) == 30 and is_frame(run, 29), "what was open stays readable"


def test_two_readers_and_their_writer(tmp_path: Path) -> None:
    path = tmp_path / "run.h5"
    writer = RunWriter(path)
    writer.start(small_scene(), 0)
    writer.frame(make_frame(0, 24))
    with open_run(path) as one, open_run(path) as two:
        writer.frame(make_frame(1, 24))
        assert len(one.refresh()) == 2 and len(two) == 1
        assert is_frame(one, 1) and is_frame(two, 0)
    writer.finish(Ending(Outcome.INTERRUPTED, "", 0.0))


def test_what_is_no_run(tmp_path: Path) -> None:
    text, empty, other, newer, cut = (
        tmp_path / name for name in ("text.h5", "empty.h5", "other.h5", "newer.h5", "cut.h5")
    )
    text.write_text("not HDF5")
    empty.touch()
    with h5py.File(other, "w") as file:
        file["x"] = 1
    drive(small_scene(), [RunWriter(newer)])
    cut.write_bytes(newer.read_bytes()[:3000])
    with h5py.File(newer, "r+") as file:
        file.attrs["derod_format"] = 99
    for path, words in [
        (tmp_path / "none.h5", "no such file"),
        (tmp_path, "no such file"),
        (text, "cannot be read as a run file"),
        (empty, "cannot be read as a run file"),
        (cut, "cannot be read as a run file"),
        (other, "is not a run file of derod"),
        (newer, "newer derod"),
    ]:
        with pytest.raises(RecordError, match=words) as caught:
            open_run(path)
        assert str(caught.value).startswith(f"{path}: ") and "\n" not in str(caught.value)


def test_a_damaged_run_is_a_record_error(tmp_path: Path) -> None:
    """A file of the right format with a part missing, or one that cannot be understood."""
    path = tmp_path / "run.h5"
    for part in ("committed", "ending", "parameters"):
        drive(small_scene(), [RunWriter(path, overwrite=True)])
        with h5py.File(path, "r+") as file:
            del file[part]
        with pytest.raises(RecordError, match="damaged"):
            open_run(path)
