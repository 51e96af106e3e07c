"""What was recorded is told from what was not: flips, cuts, counters that lie, hangs."""

from __future__ import annotations

import random
import time
from collections.abc import Callable
from pathlib import Path

import h5py
import numpy as np
import pytest

from derod.errors import RecordError
from derod.files import superblock
from derod.pushing.rows import ROW
from derod.record import RunWriter, attach_extrapolated, layout, open_run, resume_copy
from tests.synthetic import drive, is_frame, make_event, make_frame, small_scene

COUNT = 40  # increments of small_scene


@pytest.fixture(scope="module")
def finished(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    path = tmp_path_factory.mktemp("finished") / "run.h5"
    drive(small_scene(), [RunWriter(path)])
    return path.read_bytes()


@pytest.fixture(scope="module")
def live(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    """A file as a killed writer leaves it."""
    path = tmp_path_factory.mktemp("live") / "run.h5"
    writer = RunWriter(path)
    writer.start(small_scene(), 0)
    for i in range(COUNT):
        if i % 5 == 4:
            writer.event(make_event(i))
        writer.frame(make_frame(i, 24))
    return path.read_bytes()


def read_back(path: Path) -> bool:
    """Whether a verified run is the one written; raises RecordError where it is refused."""
    with open_run(path, verify=True) as run:
        whole = len(run) == COUNT and all(is_frame(run, i) for i in range(COUNT))
        events = [make_event(i) for i in range(4, COUNT, 5)]
        return whole and list(run.events) == events and run.scene == small_scene()


@pytest.mark.parametrize("kind", ["finished", "live"])
def test_no_flipped_bit_gives_a_wrong_value(
    tmp_path: Path, kind: str, request: pytest.FixtureRequest
) -> None:
    data, chance = request.getfixturevalue(kind), random.Random(kind)
    path = tmp_path / "run.h5"
    refused = 0
    for _ in range(120):
        place = chance.randrange(len(data))
        flipped = bytearray(data)
        flipped[place] ^= 1 << chance.randrange(8)
        path.write_bytes(flipped)
        began = time.monotonic()
        try:
            assert read_back(path), f"byte {place}"
        except RecordError as error:
            assert "\n" not in str(error)
            refused += 1
        assert time.monotonic() - began < 5.0
    assert refused > 20, "the frames alone are more than that"


@pytest.mark.parametrize("kind", ["finished", "live"])
def test_no_cut_reads_as_zeros(tmp_path: Path, kind: str, request: pytest.FixtureRequest) -> None:
    data, chance = request.getfixturevalue(kind), random.Random(kind)
    path = tmp_path / "run.h5"
    for size in [0, 7, 47, 48, *sorted(chance.sample(range(49, len(data)), 60))]:
        path.write_bytes(data[:size])
        try:
            with open_run(path) as run:
                read = [run.frame_at(i) for i in range(len(run))]
        except RecordError:
            continue
        assert len(read) == COUNT, size
        for i, frame in enumerate(read):
            np.testing.assert_array_equal(frame.positions, make_frame(i, 24).positions)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda file: file["committed"].write_direct(np.array([COUNT + 5, 0])), "checksum"),
        (lambda file: file["committed"].write_direct(np.array([-1, 0])), "-1 frames"),
        (lambda file: file["committed"].write_direct(np.array([COUNT - 7, 0])), "checksum"),
        (lambda file: file["parameters"].attrs.create("numpy", "0.0"), "its head"),
    ],
)
def test_counters_and_heads_that_lie(
    tmp_path: Path, finished: bytes, change: Callable[[h5py.File], None], words: str
) -> None:
    path = tmp_path / "run.h5"
    path.write_bytes(finished)
    with h5py.File(path, "r+") as file:
        change(file)
    with pytest.raises(RecordError, match=words):
        open_run(path, verify=True)
    with pytest.raises(RecordError):
        resume_copy(path)


def test_a_counter_about_to_be_written_counts(tmp_path: Path, live: bytes) -> None:
    """Killed between the counter's checksum and the counter: the frame is there, and is read."""
    path = tmp_path / "run.h5"
    path.write_bytes(live)
    with open_run(path) as run:
        place = run._file[layout.COMMITTED].id.get_offset()
        counter = run._file[layout.COMMITTED][:]
    data = bytearray(live)
    data[place : place + 16] = (counter - [1, 0]).tobytes()
    path.write_bytes(data)
    assert read_back(path)


def test_a_run_goes_on_from_whole_rows_only(tmp_path: Path, finished: bytes) -> None:
    path = tmp_path / "run.h5"
    path.write_bytes(finished)
    with h5py.File(path, "r+") as file:
        file["particles/rod/position/value"][17, 3, 1] += 1e-12
    before = path.read_bytes()
    with pytest.raises(RecordError, match="increment 17 of 40 does not fit its checksum"):
        resume_copy(path)
    with pytest.raises(RecordError, match=r"increment 17 .* the 17 before it do"):
        open_run(path, verify=True)
    assert path.read_bytes() == before and list(tmp_path.iterdir()) == [path]


def test_extrapolated_rows_are_checksummed(tmp_path: Path, finished: bytes) -> None:
    from derod.record.extrapolate import DTYPE

    path = tmp_path / "run.h5"
    path.write_bytes(finished)
    path.chmod(0o640)
    attach_extrapolated(path, np.ones(COUNT, DTYPE))
    assert path.stat().st_mode & 0o777 == 0o640
    with open_run(path, verify=True) as run:
        assert run.extrapolated is not None and (run.extrapolated == np.ones(COUNT, DTYPE)).all()
    with h5py.File(path, "r+") as file:
        rows = file["extrapolated"][:]
        rows["end_tension"][3] = 2.0
        file["extrapolated"][:] = rows
    with pytest.raises(RecordError, match="extrapolated rows do not fit"):
        open_run(path, verify=True)


def test_files_of_version_0_1_are_read_and_said_to_be_unchecked(
    tmp_path: Path, finished: bytes
) -> None:
    path = tmp_path / "run.h5"
    make_old(path, finished)
    with open_run(path) as run:
        assert not run.checksummed and len(run) == COUNT
        assert run.table.dtype == ROW and run.events[0] == make_event(4)
        assert run.table[3]["end_tension"] == make_frame(3, 24).row["end_tension"]
        np.testing.assert_array_equal(run.positions(3), make_frame(3, 24).positions)
        missing = set(ROW.names or ()) - set(layout.OLDEST_COLUMNS)
        for name in missing:
            assert ROW[name].kind != "f" or np.isnan(run.table[name]).all()
        with pytest.raises(RecordError, match="not checksummed"):
            run.verify()
        assert run.has_our_columns is not bool(missing)
    resume_copy(path)  # it goes on, with columns of today
    with open_run(path, verify=True) as run:
        assert run.checksummed and len(run) == COUNT and run.has_our_columns
        assert run.table[3]["end_tension"] == make_frame(3, 24).row["end_tension"]


def make_old(path: Path, data: bytes) -> None:
    """The same run as derod 0.1 wrote it."""
    path.write_bytes(data)
    with h5py.File(path, "r+", libver=layout.LIBVER) as file:
        table = file[f"{layout.TABLE}/value"][:]
        old = {
            f"{layout.TABLE}/value": table[list(layout.OLDEST_COLUMNS)],
            layout.EVENTS: file[layout.EVENTS][:][list(layout.OLDER_EVENT_TYPE.names or ())],
            layout.ENDING: file[layout.ENDING][:][list(layout.ENDING_TYPE.names or ())],
        }
        for name, values in old.items():
            del file[name]
            file[name] = np.array(values.tolist(), np.dtype([
                (key, values.dtype[key]) for key in values.dtype.names
            ]))  # fmt: skip
        del file[layout.COMMITTED_CHECK], file.attrs[layout.CHECK]
        file.attrs["derod_format"] = 1


def test_the_superblock_is_read_as_hdf5_writes_it(finished: bytes, live: bytes) -> None:
    for data, is_live in ((finished, False), (live, True)):
        block = superblock.unpack(data[: superblock.SIZE])
        assert block.live is is_live and block.pack() == data[: superblock.SIZE]
    assert 0.9 * len(finished) < superblock.unpack(finished[:48]).end <= len(finished)
    with pytest.raises(superblock.NotOursError, match="damaged"):
        superblock.unpack(finished[:30] + b"\xff" + finished[31:48])
