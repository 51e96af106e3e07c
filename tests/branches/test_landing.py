"""Landings: exact, on every sheet, beside joints and folds, and errors that say what is wrong."""

import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from derod.branches.files.record import open_branches
from derod.branches.files.writing import write_branches
from derod.branches.half_rod.observables import observables
from derod.branches.half_rod.outcome import NotConverged
from derod.branches.half_rod.parameters import Parameters
from derod.branches.half_rod.symmetry import images, plane
from derod.branches.paths.interval import Interval, solved
from derod.branches.paths.landing import LandingError, intervals
from derod.errors import DerodError

RUNS = Path(__file__).parents[2] / "runs"


@pytest.fixture
def file(branch_file):
    with open_branches(branch_file) as opened:
        yield opened


def test_a_landing_is_exact(file):
    (landing,) = file["3D"].at(3.0)
    assert landing.values["end_shortening"] == 3.0
    assert landing.tension_error < 1e-8
    assert landing.energy_error < 1e-8
    assert landing.unstable_modes == (0, 0)
    d = file["3D"].table["end_shortening"]
    assert d[landing.interval] < 3.0 < d[landing.interval + 1]
    assert 0.0 < landing.share < 1.0


def test_all_sheets_of_ax(file):
    """Three between the folds at 0.637 pi and 1.331 pi, in the path's order, one before."""
    found = file["Ax"].at(np.pi)
    assert len(found) == 3
    assert [one.interval for one in found] == sorted(one.interval for one in found)
    assert len({round(one.values["end_tension"], 3) for one in found}) == 3
    assert len(file["Ax"].at(0.3 * np.pi)) == 1


def test_energy_and_tension_are_conjugate(file):
    """dE_hat/ddelta = f_gamma - t between landings, to third order in their distance."""
    for name, delta in (("Ax", 2.0), ("3D", 4.0), ("L2", 6.8)):
        a, b, c = (file[name].at(delta + k * 0.01)[0].values for k in range(3))
        mean = (a["end_tension"] + 4.0 * b["end_tension"] + c["end_tension"]) / 6.0
        assert c["energy_hat"] - a["energy_hat"] == pytest.approx(0.02 * (20.0 - mean), abs=1e-8)


@pytest.mark.parametrize(("name", "row", "step"), [("3D", 0, 1), ("3D", -1, -1), ("3D-L2", 0, 1)])
def test_beside_joints_states_stay_out_of_the_plane(file, name, row, step):
    """The amplitude goes like a square root; t is linear between the joint and its neighbour."""
    branch = file[name]
    row = range(len(branch))[row]
    joint, near = branch.table[row], branch.table[row + step]
    odd = plane(branch.state(row))[1].kept
    whole = np.linalg.norm(branch.state(row + step).kept[odd])
    for share in (0.05, 0.25, 0.81):
        span = near["end_shortening"] - joint["end_shortening"]
        (landing,) = branch.at(joint["end_shortening"] + share * span)
        amplitude = np.linalg.norm(landing.state.kept[odd])
        assert amplitude == pytest.approx(np.sqrt(share) * whole, rel=0.1)
        tension = joint["end_tension"] + share * (near["end_tension"] - joint["end_tension"])
        scale = abs(near["end_tension"] - joint["end_tension"])
        assert landing.values["end_tension"] == pytest.approx(tension, abs=0.1 * scale)


def test_a_joint_itself_is_planar_and_special(file):
    branch = file["3D"]
    (landing,) = branch.at(branch.table["end_shortening"][0])
    assert landing.special
    assert plane(landing.state) is not None
    assert landing.interval == 0
    assert landing.share == 0.0


def test_two_states_beside_a_fold(file):
    """1e-9 to 1e-3 D below Ax's fold: two sheets, apart by a square root, errors said."""
    branch = file["Ax"]
    fold = next(b for b in branch.bifurcations if b["kind"] == b"fold")
    apart = []
    for below in (1e-9, 1e-7, 1e-5, 1e-3):
        found = branch.at(float(fold["end_shortening"]) - below)
        pair = [one for one in found if abs(one.values["end_tension"] - fold["end_tension"]) < 0.5]
        assert len(pair) == 2
        apart.append(abs(pair[1].values["end_tension"] - pair[0].values["end_tension"]))
    assert apart[3] / apart[1] == pytest.approx(100.0, rel=0.05)
    assert apart[2] / apart[1] == pytest.approx(10.0, rel=0.05)
    assert len(branch.at(float(fold["end_shortening"]) + 1e-5)) == 1  # the third sheet alone


def test_a_fold_that_is_no_stored_point_is_found(tmp_path, branches):
    """The same branch without its fold's row: both sheets in one interval."""
    branch = branches["Ax"]
    at = next(b.index for b in branch.bifurcations if b.kind == "fold")
    points = [p for i, p in enumerate(branch.points) if i != at]
    first, last = at - 5, at + 5
    cut = replace(branch, points=points[first:last], bifurcations=[])
    write_branches(tmp_path / "cut.h5", Parameters(), [cut])
    fold = branch.points[at].values["end_shortening"]
    top = max(p.values["end_shortening"] for p in cut.points)
    with open_branches(tmp_path / "cut.h5") as file:
        delta = 0.5 * (fold + top)
        found = file["Ax"].at(delta)
        assert len(found) == 2
        assert found[0].interval == found[1].interval
        assert found[0].share < found[1].share
        with pytest.raises(LandingError, match="no state"):
            file["Ax"].at(fold + 1e-4)
    with open_branches(tmp_path / "cut.h5") as file:
        assert [one.values["end_tension"] for one in file["Ax"].at(delta)] == pytest.approx(
            _tensions(branch, fold, delta), rel=1e-6
        )


def _tensions(branch, fold, delta):
    """On both sides of the fold, from the stored points: t is a cubic in x = sqrt(fold - delta)."""
    at = next(b.index for b in branch.bifurcations if b.kind == "fold")
    values = [p.values for p in branch.points[at - 3 : at + 4]]
    x = np.sqrt([max(fold - v["end_shortening"], 0.0) for v in values])
    x[:3] *= -1.0
    fit = np.polyfit(x, [v["end_tension"] for v in values], 6)
    return [np.polyval(fit, -np.sqrt(fold - delta)), np.polyval(fit, np.sqrt(fold - delta))]


def test_outside_the_branch(file):
    with pytest.raises(DerodError, match=r"3D has no state at delta = 9; allowed: 0\.76"):
        file["3D"].at(9.0)


def test_a_wrong_interval_is_refused(file):
    """A stored point moved off the branch: no landing is made up beside it."""
    branch = file["3D"]
    i = intervals(branch, 3.0)[0]
    branch.table["energy_hat"][i] += 1.0
    branch.all_nodes[branch._start[i + 1] + 2 * i : branch._start[i + 2] + 2 * (i + 2), 0] += 0.3
    with pytest.raises(LandingError, match="3D at delta = 3"):
        branch.at(3.0)


def test_flat_states_are_not_on_a_space_path(file):
    """What version 0.1 returned beside a joint: the planar state, of the same projection."""
    branch = file["3D"]
    interval = Interval(branch, 0, float(branch.table["end_shortening"][1]))
    place = interval.at(0.5 * interval.length)
    odd = interval.joint[1].states
    flat = place.state.nodes.copy()
    flat[:, odd] = 0.0
    with pytest.raises(NotConverged, match="flat"):
        interval.check(
            replace(place, settled=replace(place.settled, state=replace(place.state, nodes=flat)))
        )


def test_solved_points_are_the_stored_ones(file, branches):
    for name, i in (("Ax", 30), ("3D", 0), ("3D", 10), ("L2", -1)):
        state = solved(file[name], range(len(file[name]))[i]).state
        wanted = branches[name].points[i].values
        own = observables(state)
        for key in ("end_shortening", "end_tension", "energy_hat"):
            assert own[key] == pytest.approx(wanted[key], rel=1e-8)  # the paths are traced to 1e-9


def test_images_are_states(file):
    """All images of a state have its size, and the eight differ on a space curve."""
    kept = file["3D"].state(10).kept
    found = images(kept)
    assert len({tuple(np.round(image, 9)) for image in found}) == 8
    for image in found:
        assert np.linalg.norm(image) == pytest.approx(np.linalg.norm(kept))


def test_landings_on_one_random_scene():
    """The command of the validation, on its first scene."""
    command = [sys.executable, str(RUNS / "landings.py"), "--count", "1", "--seed", "1"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    assert " 0 wrong, 0 missing" in done.stdout.splitlines()[-1]
