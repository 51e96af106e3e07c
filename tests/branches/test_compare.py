"""Runs made of branch states: exact ones, disturbed ones, and ones that lie nowhere."""

from pathlib import Path

import numpy as np
import pytest

from derod.branches.files.compare import compare, shape_distance, worst
from derod.branches.files.record import open_branches
from derod.branches.files.report import exceeds, report
from derod.branches.half_rod.center_line import center_line
from derod.errors import SceneError
from derod.scene import load_scene

RUNS = Path(__file__).parents[2] / "runs"
PLACES = (("Ax", 0.1), ("Ax", 0.2), ("3D", 0.3), ("3D", 1.05), ("L2", 2.15), ("3D-L2", 2.5))
DTYPE = [(n, "f8") for n in ("end_shortening", "end_tension", "energy_hat", "wetted_length")]


class FakeRun:
    """What compare needs of a run, made of branch states turned about the clamp axis."""

    def __init__(self, file, scene="paper-text.toml"):
        self.scene = load_scene(RUNS / scene)
        self.landings = []
        for name, delta in PLACES:
            self.landings.append(file[name].at(delta * np.pi)[0])
        self.table = np.zeros(len(PLACES), DTYPE)
        for row, landing in zip(self.table, self.landings, strict=True):
            for name in self.table.dtype.names:
                row[name] = landing.values[name]

    def __len__(self):
        return len(self.table)

    def arc_length(self, i):
        return np.linspace(0.0, 10.0, 201)

    def positions(self, i):
        r = center_line(self.landings[i].state, self.arc_length(i))
        angle = 0.3 * i
        turned = (r[:, 0] + 1j * r[:, 1]) * np.exp(1j * angle)
        side = -1.0 if i % 2 else 1.0
        return np.stack([side * turned.real, turned.imag, r[:, 2]], axis=1)


@pytest.fixture
def file(branch_file):
    with open_branches(branch_file) as opened:
        yield opened


def test_branch_states_lie_on_their_branches(file):
    result = compare(FakeRun(file), file)
    assert list(result["branch"]) == [name for name, _ in PLACES]
    for name in ("tension_error", "energy_error", "wetted_error", "shape_error"):
        assert result[name].max() < 1e-8
    assert not exceeds(result, 1e-7)


def test_errors_are_measured(file):
    run = FakeRun(file)
    run.table["end_tension"][3] *= 1.0 + 3e-4
    run.table["energy_hat"][4] -= 2e-3
    result = compare(run, file)
    assert result["tension_error"][3] == pytest.approx(3e-4, rel=1e-6)
    reference = run.landings[4].values["energy_hat"]
    assert result["energy_error"][4] == pytest.approx(2e-3 / reference, rel=1e-6)
    assert exceeds(result, 2e-4)
    assert not exceeds(result, 4e-4)
    assert worst(result)["tension_error"] == pytest.approx((3e-4, 1.05 * np.pi), rel=1e-6)


def test_a_row_on_no_branch_is_said_to_be(file):
    run = FakeRun(file)
    run.table["energy_hat"][2] *= 1.5
    run.table["end_tension"][5] = -4.0
    result = compare(run, file)
    assert list(result["branch"] == "") == [False, False, True, False, False, True]
    assert "on no branch: 2 rows between 0.30000 pi and 2.50000 pi" in report(result, quiet=True)
    assert exceeds(result, 1.0)


def test_every(file):
    assert list(compare(FakeRun(file), file, every=2)["row"]) == [0, 2, 4]


def test_other_scene_is_refused(file):
    with pytest.raises(SceneError, match=r"wall_strength = 0\.02"):
        compare(FakeRun(file, "paper-figures.toml"), file)


def test_shape_distance_sees_shapes_not_poses(rng):
    s = np.linspace(0, 1, 50)
    curve = np.stack([np.sin(3 * s), s**2 * np.cos(2 * s), s], axis=1)
    turned = (curve[:, 0] + 1j * curve[:, 1]) * np.exp(0.7j)
    pose = np.stack([-turned.real, turned.imag, s], axis=1)
    assert shape_distance(pose, curve) < 1e-14
    pose[20, 2] += 0.01
    assert shape_distance(pose, curve) == pytest.approx(0.01, abs=1e-9)
