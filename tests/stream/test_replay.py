import subprocess
import sys
import time

import numpy as np
import pytest

from derod.branches import Parameters
from derod.record import RunWriter, open_run
from derod.views.stream.replay import lowest_sheet, replay_branches, replay_file, sheets
from derod.views.stream.target import parse_target
from derod.views.stream.viewers import close_recording
from tests.stream.reading import read_rrd, seconds
from tests.stream.test_stream import PLOTS, SHAPES
from tests.synthetic import drive, small_scene


@pytest.fixture
def run_file(tmp_path):
    path = tmp_path / "run.h5"
    drive(small_scene(), [RunWriter(path)])
    return path


def test_a_run_file_is_replayed_whole(run_file, tmp_path):
    target = tmp_path / "replay.rrd"
    opened = replay_file(str(run_file), parse_target(str(target)), "curvature")
    assert close_recording(opened.recording, 20) is None
    contents = read_rrd(target)
    with open_run(run_file) as run:
        delta = run.table["end_shortening"]
        for entity in (*SHAPES, *PLOTS):
            assert contents[entity].rows == len(run), entity
            assert sorted(contents[entity].times["increment"]) == list(range(len(run)))
            assert sorted(seconds(contents[entity].times["end_shortening"])) == pytest.approx(
                delta, abs=1e-8
            )
        assert contents["events"].rows == len(run.events) + 1
    assert contents.blueprints == 1


def test_three_hundred_increments_take_less_than_three_seconds(tmp_path):
    path, target = tmp_path / "long.h5", tmp_path / "long.rrd"
    drive(small_scene(mesh__edges=300, push__stop="3 pi", rod__length=12), [RunWriter(path)])
    began = time.process_time()  # as the wall would tell on a machine that does nothing else
    opened = replay_file(str(path), parse_target(str(target)), "tension")
    assert close_recording(opened.recording, 20) is None
    taken = time.process_time() - began
    assert read_rrd(target)["plots/tension"].rows == 300
    assert taken < 3.0


def test_the_command(run_file, tmp_path):
    target = tmp_path / "command.rrd"
    command = [sys.executable, "-m", "derod", "view", str(run_file), "--save", str(target)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert target.stat().st_size > 10_000
    for wrong in (["nothing.h5"], [str(run_file), "--save", "x.h5"]):
        command = [sys.executable, "-m", "derod", "view", *wrong]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        assert done.returncode == 2
        assert done.stderr.startswith("derod: error: ")
        assert "Traceback" not in done.stderr


class Branch:
    """Looks like a branch of ``derod.open_branches``."""

    parameters = Parameters()

    def __init__(self, points: int) -> None:
        self.table = np.zeros(
            points, [("end_shortening", "f8"), ("end_tension", "f8"), ("energy_hat", "f8")]
        )
        self.table["end_shortening"] = np.linspace(0, 1, points)
        self.table["end_tension"] = np.arange(points)
        self.bifurcations = np.array(
            [(b"fold", 3, 0.5, 2.0, 1.0)],
            [("kind", "S16"), ("index", "i8"), ("end_shortening", "f8"), ("end_tension", "f8"),
             ("energy_hat", "f8")],
        )  # fmt: skip

    def positions(self, i: int) -> np.ndarray:
        return np.outer(np.arange(5 + i % 3), [0.0, 0.0, 1.0])

    def drop_center(self, i: int) -> np.ndarray:
        return np.zeros(3)


def test_branches_have_an_entity_a_path(tmp_path):
    import rerun as rr

    target = tmp_path / "branches.rrd"
    recording = rr.RecordingStream("derod")
    recording.save(str(target))
    replay_branches(recording, {"Ax": Branch(10), "3D-L2": Branch(7)})
    assert close_recording(recording, 20) is None
    contents = read_rrd(target)
    assert "LineStrips3D:strips" in contents["world/drop/edge"].static
    for name, points in (("Ax", 10), ("3D-L2", 7)):
        rods = contents[f"world/branches/{name}"]
        assert rods.times["point"] == list(range(points))
        assert rods.rows == points + len(rods.times["end_shortening"])
        assert contents[f"branches/tension/{name}/0"].times["point"] == list(range(points))
        assert contents[f"branches/energy_hat/{name}/0"].rows == points
    assert contents["events"].rows == 2


def test_sheets_of_a_path_that_folds_twice():
    delta = np.array([0.0, 1, 2, 3, 2, 1, 2, 3, 4])
    assert sheets(delta) == [(0, 3), (3, 5), (5, 8)]
    table = np.zeros(9, [("end_shortening", "f8"), ("energy_hat", "f8")])
    table["end_shortening"], table["energy_hat"] = delta, [0, 1, 2, 9, 8, 7, 1.5, 1.6, 1.7]
    shown = lowest_sheet(table)
    assert shown.tolist() == [True, True, False, False, False, False, True, True, True]
