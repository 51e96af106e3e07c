"""Sweeps that are interrupted, killed, poisoned, and short of room, on real processes of Dask."""

from __future__ import annotations

import os
import random
import signal
import subprocess
import sys
import threading
import time
from collections import Counter
from pathlib import Path

import numpy as np
import pytest

from derod.errors import InUseError, RecordError
from derod.files.outputs import RefusedError
from derod.sweeps import engines
from derod.sweeps import journal as journals
from derod.sweeps.files import Sweep
from derod.sweeps.hand import Hand
from derod.sweeps.journal import Journal, folder_of
from derod.sweeps.running import Means, Tally, run_sweep
from tests.sweeps import work
from tests.sweeps.conftest import Make

distributed = pytest.importorskip("distributed")


def test_two_processes_and_one_write_the_same_bytes(plan: Make, log: str, tmp_path: Path) -> None:
    made = plan(6, rows="landings")
    one, two = tmp_path / "one.h5", tmp_path / "two.h5"
    run_sweep(made, one, Means())
    tally = run_sweep(made, two, Means(workers=2, work=work.pushing, batch=0.0, runs=log))
    assert one.read_bytes() == two.read_bytes()
    assert sorted(work.tried(log)) == list(range(6)) and tally.outcomes == {"completed": 6}
    sweep = Sweep(two)
    assert sweep.complete and list(sweep.rows["point"]) == [p for p in range(6) for _ in range(3)]
    assert np.all(np.diff(sweep.outcomes["drop.capillary_force"]) > 0)
    assert not folder_of(two).exists()


def test_a_poisonous_point_is_set_aside_and_a_resume_tries_it_again(
    plan: Make, log: str, tmp_path: Path
) -> None:
    path, said = tmp_path / "s.h5", list[str]()
    means = Means(workers=2, work=work.poisonous, batch=0.0, runs=log, say=said.append)
    tally = run_sweep(plan(8), path, means)
    assert tally.outcomes == {"completed": 7, "killed_worker": 1}
    tries = Counter(work.tried(log))
    assert tries[3] == 2 and tries.total() <= 11  # a result may die with its worker on its way here
    (failure,) = Sweep(path).failures()
    assert failure["point"] == 3 and failure["message"] == b"the worker that pushed it died 2 times"
    assert said == ["point 3: its worker died: once more"]
    tally = run_sweep(None, path, Means(work=work.quick, batch=0.0, runs=log))
    assert tally.before == 7 and tally.done == 1 and not Sweep(path).failures().size
    assert Counter(work.tried(log))[3] == 3


def test_a_poisonous_point_of_a_batch_is_found(log: str) -> None:
    said = list[str]()
    with engines._client(1, None) as client:
        hand = Hand(client, work.poisonous, _job(log), foreign=False, batch=0.05, say=said.append)
        results = list(hand.out(((p, {"drop.capillary_force": 1.0}) for p in range(24)), 24))
    assert sorted(result.point for result in results) == list(range(24))
    assert [result.point for result in results if result.outcome != "completed"] == [3]
    assert said[-1] == "point 3: its worker died: once more"
    assert any("3" in line.split(":")[0].split(", ") for line in said[:-1])  # its batch


def test_workers_that_die_are_replaced(plan: Make, log: str, tmp_path: Path) -> None:
    path = tmp_path / "s.h5"
    tally = run_sweep(plan(8), path, Means(workers=2, work=work.once_deadly, batch=0.0, runs=log))
    assert tally.outcomes == {"completed": 8}
    tries = Counter(work.tried(log))
    assert tries[2] >= 2 and tries[5] >= 2
    assert tries.total() <= 12  # a result may die with its worker on its way here


def test_a_worker_killed_from_outside_costs_one_point_once_more(
    plan: Make, log: str, tmp_path: Path
) -> None:
    killed = threading.Event()

    def watch(tally: Tally) -> None:
        if tally.done == 3 and not killed.is_set():
            os.kill(work.processes(log)[-1], signal.SIGKILL)
            killed.set()

    path = tmp_path / "s.h5"
    tally = run_sweep(
        plan(12), path, Means(workers=2, work=work.quick, batch=0.0, runs=log), watch=watch
    )
    assert killed.is_set() and tally.outcomes == {"completed": 12}
    assert len(work.tried(log)) <= 13 and set(work.tried(log)) == set(range(12))


def test_a_bug_in_one_point_is_its_outcome(plan: Make, log: str, tmp_path: Path) -> None:
    path = tmp_path / "s.h5"
    tally = run_sweep(plan(4), path, Means(workers=2, work=work.broken, batch=0.0, runs=log))
    assert tally.outcomes == {"completed": 3, "error": 1}
    assert Sweep(path).failures()["message"][0] == b"RuntimeError: a bug"


KILLED = """
import sys
from pathlib import Path
from derod.sweeps.plan import plan_of_text
from derod.sweeps.running import Means, run_sweep
from tests.sweeps import work
text, path, log = sys.argv[1:]
plan = None if text == "-" else plan_of_text(Path(text).read_text(), "plan")
run_sweep(plan, Path(path), Means(work=work.quick, batch=0.0, runs=log))
"""


def test_a_sweep_killed_again_and_again_comes_to_the_same_table(
    plan: Make, log: str, tmp_path: Path
) -> None:
    made = plan(20)
    whole, path, text = tmp_path / "whole.h5", tmp_path / "s.h5", tmp_path / "plan.json"
    run_sweep(made, whole, Means(work=work.quick, runs=str(tmp_path)))
    text.write_text(made.text)
    chance, kills, source = random.Random(7), 0, str(text)
    while True:
        command = [sys.executable, "-c", KILLED, source, str(path), log]
        process = subprocess.Popen(command, cwd=Path(__file__).parents[2])
        begun = len(work.tried(log))
        wanted = begun + chance.randint(1, 4)
        while process.poll() is None and (kills >= 4 or len(work.tried(log)) < wanted):
            time.sleep(0.005)
        if process.poll() is not None:
            assert process.returncode == 0
            break
        time.sleep(chance.random() * work.SLOW)
        process.kill()
        process.wait()
        kills, source = kills + 1, "-"
    assert kills == 4 and path.read_bytes() == whole.read_bytes()
    assert len(work.tried(log)) <= 20 + kills  # nothing was run twice but what was running


def test_ctrl_c_keeps_what_is_finished(plan: Make, log: str, tmp_path: Path) -> None:
    path = tmp_path / "s.h5"

    def watch(tally: Tally) -> None:
        if tally.done == 5:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        run_sweep(plan(8), path, Means(work=work.quick, batch=0.0, runs=log), watch=watch)
    half = Sweep(path)
    assert not half.complete and list(half.outcomes["outcome"]).count(b"not_reached") == 3
    assert len(half.rows) == 5
    tally = run_sweep(None, path, Means(work=work.quick, batch=0.0, runs=log))
    assert (tally.before, tally.done) == (5, 3) and work.tried(log) == list(range(8))
    assert Sweep(path).complete and not folder_of(path).exists()


def test_a_scheduler_that_is_started_anew_gets_the_points_again(
    plan: Make, log: str, tmp_path: Path
) -> None:
    port = distributed.utils.open_port()
    cluster = [_scheduler(port), *_workers(port)]

    def watch(tally: Tally) -> None:
        if tally.done == 4 and len(cluster) == 2:
            for process in cluster:
                process.kill()
                process.wait()
            cluster.extend([_scheduler(port), *_workers(port)])

    try:
        path = tmp_path / "s.h5"
        means = Means(scheduler=f"tcp://127.0.0.1:{port}", work=work.quick, batch=0.0, runs=log)
        tally = run_sweep(plan(8), path, means, watch=watch)
        assert len(cluster) == 4 and tally.outcomes == {"completed": 8}
        assert len(work.tried(log)) <= 9 and Sweep(path).complete
    finally:
        for process in cluster:
            process.kill()
            process.wait()


def _scheduler(port: int) -> subprocess.Popen[bytes]:
    words = ["scheduler", "--host", "127.0.0.1", "--port", str(port), "--no-dashboard", "--no-show"]
    return _dask(words)


def _workers(port: int) -> list[subprocess.Popen[bytes]]:
    words = ["worker", f"tcp://127.0.0.1:{port}", "--nthreads", "1", "--no-nanny", "--no-dashboard"]
    return [_dask(words)]


def _dask(words: list[str]) -> subprocess.Popen[bytes]:
    return subprocess.Popen(
        [sys.executable, "-m", "dask", *words],
        cwd=Path(__file__).parents[2],
        env=os.environ | {"PYTHONPATH": str(Path(__file__).parents[2])},
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )


def test_a_full_disk_stops_the_sweep_and_keeps_what_is_finished(
    plan: Make, log: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    import errno

    path, put = tmp_path / "s.h5", Path.write_bytes

    def write(self: Path, data: bytes) -> int:
        if len(work.tried(log)) > 3 and self.parent == folder_of(path):
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        return put(self, data)

    means = Means(work=work.quick, batch=0.0, runs=log)
    with monkeypatch.context() as patch:
        patch.setattr(Path, "write_bytes", write)
        with pytest.raises(RecordError, match="no space left on device; 3 of 8 points are kept"):
            run_sweep(plan(8), path, means)
    assert run_sweep(None, path, means).before == 3 and Sweep(path).complete


def test_no_room_for_the_table_keeps_the_journal(
    plan: Make, log: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def full(*_: object) -> None:
        raise OSError(28, "No space left on device")

    path, means = tmp_path / "s.h5", Means(work=work.quick, batch=0.0, runs=log)
    with monkeypatch.context() as patch:
        patch.setattr(os, "posix_fallocate", full)
        with pytest.raises(RecordError, match="cannot be written: no space left on device"):
            run_sweep(plan(4), path, means)
    assert not path.exists() and len(list(folder_of(path).glob("0*.h5"))) == 4
    assert run_sweep(None, path, means).done == 0 and Sweep(path).complete


def test_a_damaged_point_is_pushed_again(plan: Make, log: str, tmp_path: Path) -> None:
    path, made, said = tmp_path / "s.h5", plan(4), list[str]()
    with Journal.begin(path, made) as journal:
        for point, values in enumerate(made.points()):
            journal.put(work.quick(_job(log), point, made.changes(values)))
    victim = next(folder_of(path).glob("000002-*.h5"))
    data = bytearray(victim.read_bytes())
    data[len(data) // 2] ^= 1
    victim.write_bytes(data)
    tally = run_sweep(None, path, Means(work=work.quick, batch=0.0, runs=log, say=said.append))
    assert tally.done == 1 and said == ["1 files of finished points are damaged: pushed again"]


def _job(log: str) -> work.Job:
    return work.Job("", None, "last", log)


def test_one_sweep_a_journal(plan: Make, log: str, tmp_path: Path) -> None:
    path = tmp_path / "s.h5"
    with Journal.begin(path, plan(3)):
        with pytest.raises(InUseError, match=f"written by process {os.getpid()}"):
            Journal.resume(path)
        with pytest.raises(RefusedError, match="a sweep was begun there"):
            run_sweep(plan(3), path, Means())
    with pytest.raises(RecordError, match="no sweep was begun there"):
        Journal.resume(tmp_path / "other.h5")


def test_a_result_comes_back_from_its_file(plan: Make, log: str) -> None:
    result = work.quick(_job(log), 2, {"drop.capillary_force": 3.0})
    again = journals.decoded(journals.encoded(result), "x")
    assert again.rows.tobytes() == result.rows.tobytes()
    assert (again.point, again.outcome, again.message) == (2, "completed", "point 2")


def test_a_flipped_bit_in_the_file_is_found(plan: Make, log: str, tmp_path: Path) -> None:
    path = tmp_path / "s.h5"
    run_sweep(plan(4), path, Means(work=work.quick, batch=0.0, runs=log))
    whole = path.read_bytes()
    places = [whole.index(b"point 1"), whole.index(b'"design"'), whole.rindex(b"\x00\x00\x3e\x40")]
    for place in places:
        path.write_bytes(whole[:place] + bytes([whole[place] ^ 1]) + whole[place + 1 :])
        with pytest.raises(RecordError, match="is damaged"):
            Sweep(path)
