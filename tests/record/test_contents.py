"""What is written is what is read, and the writer refuses what does not belong."""

from __future__ import annotations

import datetime
from pathlib import Path

import h5py
import numpy as np
import pytest

import derod
from derod.errors import RecordError
from derod.pushing.frames import Ending, Event, Outcome
from derod.pushing.rows import ROW
from derod.record import RunWriter, growing, layout, open_run, resume_copy
from tests.synthetic import drive, is_frame, make_event, make_frame, small_scene

COUNT = 40  # increments of small_scene


@pytest.fixture
def finished(tmp_path: Path) -> Path:
    path = tmp_path / "run.h5"
    drive(small_scene(), [RunWriter(path)])
    return path


def test_everything_comes_back(finished: Path) -> None:
    with open_run(finished) as run:
        assert len(run) == COUNT
        assert run.table.dtype == ROW
        assert all(is_frame(run, i) for i in range(COUNT))
        assert list(run.events) == [make_event(i) for i in range(4, COUNT, 5)]
        assert run.ending == Ending(Outcome.COMPLETED, "reached 0.4 pi", 0.4 * np.pi)
        assert run.outcome is Outcome.COMPLETED


def test_the_file_says_what_it_is(finished: Path) -> None:
    scene = small_scene(noise__seed=12345)
    path = finished.with_name("seeded.h5")
    drive(scene, [RunWriter(path)])
    with open_run(path) as run:
        assert run.scene == scene
        assert run.scene.path == str(path)
        assert run.versions["seed"] == 12345
        assert run.versions["derod"] == derod.__version__
        assert run.versions["numpy"] == np.__version__
        assert run.versions["h5py"] == h5py.__version__
        assert run.versions["created"] == run.versions["opened"]
    with h5py.File(path) as file:
        assert file[layout.SCENE][()].decode() == scene.text
        assert file.attrs["derod_format"] == layout.FORMAT
        assert tuple(file["h5md"].attrs["version"]) == layout.H5MD_VERSION
        table = file[f"{layout.TABLE}/value"]
        for name in ROW.names or ():
            if ROW[name] == np.dtype("f8") and name != "next_step":  # that counts in the control's
                assert table.attrs[f"unit {name}"].decode() == layout.ROW_UNITS[name]
        for name, unit in layout.UNITS.items():
            if name == layout.EDGE_FRAME:  # of sections with directions only
                assert name not in file
                continue
            assert file[f"{name}/value"].attrs["unit"].decode() == unit


def test_elements_share_their_steps_and_times(finished: Path) -> None:
    with h5py.File(finished) as file:
        for name in layout.ELEMENTS:
            group = file[name]
            assert len(group["value"]) == COUNT, name
            assert list(group["step"]) == list(range(COUNT))
            np.testing.assert_array_equal(
                group["time"], file[f"{layout.TABLE}/value"]["end_shortening"]
            )
        assert list(file[layout.COMMITTED]) == [COUNT, len(file[layout.EVENTS])]


def test_a_finished_file_holds_no_room_it_does_not_need(finished: Path) -> None:
    with h5py.File(finished) as file:
        assert finished.stat().st_size == file.id.get_filesize()
    assert [entry.name for entry in finished.parent.iterdir()] == ["run.h5"]


def test_folders_are_made_and_an_existing_file_stays(tmp_path: Path) -> None:
    path = tmp_path / "a" / "b" / "run.h5"
    drive(small_scene(), [RunWriter(path)])
    before = path.read_bytes()
    with pytest.raises(RecordError, match="exists already"):
        RunWriter(path).start(small_scene(), 0)
    assert path.read_bytes() == before
    drive(small_scene(push__stop="0.3 pi"), [RunWriter(path, overwrite=True)])
    with open_run(path) as run:
        assert len(run) == 30


def test_a_relative_path(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    drive(small_scene(), [RunWriter("run.h5")])
    with open_run("run.h5") as run:
        assert len(run) == COUNT and run.path == "run.h5"


def test_frames_that_do_not_belong_are_refused(tmp_path: Path) -> None:
    path = tmp_path / "run.h5"
    writer = RunWriter(path)
    with pytest.raises(RecordError, match="not open"):
        writer.frame(make_frame(0, 24))
    with pytest.raises(RecordError, match="needs the frames before it"):
        writer.start(small_scene(), 3)
    assert not path.exists()
    writer.start(small_scene(), 0)
    with pytest.raises(RecordError, match=r"positions has shape \(26, 3\), not \(25, 3\)"):
        writer.frame(make_frame(0, 25))
    with pytest.raises(RecordError, match="increment 1 follows frame -1"):
        writer.frame(make_frame(1, 24))
    writer.frame(make_frame(0, 24))
    with pytest.raises(RecordError, match="increment 0 follows frame 0"):
        writer.frame(make_frame(0, 24))
    writer.frame(make_frame(1, 24))
    writer.finish(Ending(Outcome.INTERRUPTED, "enough", 0.02))
    writer.finish(Ending(Outcome.COMPLETED, "a second call changes nothing", 0.02))
    with open_run(path) as run:
        assert len(run) == 2 and run.outcome is Outcome.INTERRUPTED
        assert is_frame(run, 0) and is_frame(run, 1)


def test_long_messages_are_cut_between_characters(tmp_path: Path) -> None:
    path = tmp_path / "run.h5"
    writer = RunWriter(path)
    writer.start(small_scene(), 0)
    writer.event(Event(0, "snap", 0.01, np.nan, np.nan, "a" + "é" * 2000))
    writer.frame(make_frame(0, 24))
    writer.finish(Ending(Outcome.DIVERGED, "é" * 2000, 0.01))
    with open_run(path) as run:
        assert run.events[0].message == "a" + "é" * ((layout.MESSAGE_BYTES - 1) // 2)
        assert run.ending is not None
        assert run.ending.message == "é" * (layout.MESSAGE_BYTES // 2)


def test_a_finished_run_is_copied_and_goes_on(finished: Path) -> None:
    longer = small_scene(push__stop="0.5 pi")
    before = finished.stat().st_ino
    writer = resume_copy(finished, longer)
    assert finished.stat().st_ino != before, "a new file took its place"
    with open_run(finished) as run:
        drive(longer, [writer], run)
    with open_run(finished) as run:
        assert len(run) == 50 and run.scene == longer
        assert all(is_frame(run, i) for i in range(50))
        assert list(run.events) == [make_event(i) for i in range(4, 50, 5)]
        assert run.ending is not None and run.ending.end_shortening == 0.5 * np.pi
    assert [entry.name for entry in finished.parent.iterdir()] == ["run.h5"]


def test_a_copy_keeps_its_birthday_and_says_when_it_was_opened(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "run.h5"

    class LongAgo(datetime.datetime):
        @classmethod
        def now(cls, tz: datetime.tzinfo | None = None) -> datetime.datetime:
            return datetime.datetime(2001, 2, 3, 4, 5, 6, tzinfo=tz)

    with monkeypatch.context() as patch:
        patch.setattr(growing.datetime, "datetime", LongAgo)
        drive(small_scene(), [RunWriter(path)])
    resume_copy(path).finish(Ending(Outcome.INTERRUPTED, "at once", 0.0))
    with open_run(path) as run:
        assert run.created == "2001-02-03T04:05:06+00:00"
        assert run.versions["opened"] > "2026"
        assert len(run) == COUNT


def test_what_cannot_be_resumed(finished: Path, tmp_path: Path) -> None:
    before = finished.read_bytes()
    with pytest.raises(RecordError, match="another mesh"):
        resume_copy(finished, small_scene(mesh__edges=30))
    with pytest.raises(RecordError, match="no such file"):
        resume_copy(tmp_path / "none.h5")
    assert finished.read_bytes() == before
    writer = resume_copy(finished)
    with pytest.raises(RecordError, match="has 40 frames"):
        writer.start(small_scene(), 39)


def test_events_of_a_frame_that_never_came_are_left_out_of_a_copy(tmp_path: Path) -> None:
    """The resumed push tells them again."""
    path = tmp_path / "run.h5"
    writer = RunWriter(path)
    writer.start(small_scene(), 0)
    for i in range(4):
        writer.frame(make_frame(i, 24))
    writer.event(make_event(4))
    writer.finish(Ending(Outcome.INTERRUPTED, "", 0.04))
    with open_run(path) as run:
        assert run.events == (make_event(4),)
    resume_copy(path).finish(Ending(Outcome.INTERRUPTED, "", 0.04))
    with open_run(path) as run:
        assert run.events == () and len(run) == 4
