"""Branch files: what is written is read back, and bad files are refused."""

import h5py
import numpy as np
import pytest

from derod.branches.files.record import open_branches
from derod.branches.files.writing import write_branches
from derod.branches.half_rod.observables import observables
from derod.branches.half_rod.parameters import Parameters
from derod.errors import DerodError


def test_round_trip(branch_file, branches):
    with open_branches(branch_file) as file:
        assert file.names == list(branches)
        assert file.parameters == Parameters()
        assert file.scene_text == "text of the scene"
        for name, branch in file.items():
            own = branches[name]
            assert len(branch) == len(own.points)
            for column in (
                "end_shortening",
                "end_tension",
                "energy_hat",
                "wetted_length",
                "drop_y",
            ):
                expected = [p.values[column] for p in own.points]
                assert np.array_equal(branch.table[column], expected)
            assert branch.ends == own.ends
            assert [b.decode() for b in branch.bifurcations["partner"]] == [
                b.partner for b in own.bifurcations
            ]


def test_states_can_be_continued_from(branch_file, branches):
    with open_branches(branch_file) as file:
        state = file["3D"].state(20)
    exact = branches["3D"].points[20].state
    assert np.array_equal(state.nodes, exact.nodes)
    assert np.abs(state.stages - exact.stages).max() < 2e-3
    assert observables(state)["energy_hat"] == pytest.approx(
        observables(exact)["energy_hat"], rel=1e-3
    )


def test_centre_lines(branch_file):
    """From clamp to clamp, inextensible, symmetric under the half turn, tangent to the clamps."""
    with open_branches(branch_file) as file:
        for name in ("Ax", "3D", "L2"):
            branch = file[name]
            i = len(branch) // 2
            r, s = branch.positions(i), branch.arc_length(i)
            delta = branch.table[i]["end_shortening"]
            assert np.abs(r[0]).max() < 1e-8
            assert np.allclose(r[-1], [0.0, 0.0, 10.0 - delta], atol=1e-8)
            assert s[0] == pytest.approx(0.0, abs=1e-12)
            assert s[-1] == pytest.approx(10.0, abs=1e-12)
            steps = np.linalg.norm(np.diff(r, axis=0), axis=1)
            assert (steps <= np.diff(s) * (1 + 1e-5)).all()
            assert steps.sum() == pytest.approx(10.0, rel=2e-3)
            centre = branch.drop_center(i)
            turned = (r[::-1] - centre) * [-1.0, 1.0, -1.0] + centre
            assert np.allclose(turned, r, atol=1e-9)
            inside = np.linalg.norm(r - centre, axis=1).min()
            assert inside < 0.55


def test_stiffer_rods_are_written_in_units_of_k0(tmp_path, branches):
    """K = 2 K0, k3, f_gamma, v0 doubled: the same shapes, twice the forces and energies."""
    from dataclasses import replace

    branch = branches["3D-L2"]
    stiff = replace(Parameters(), bending=2.0)
    points = [replace(p, state=replace(p.state, parameters=stiff)) for p in branch.points]
    write_branches(tmp_path / "stiff.h5", stiff, [replace(branch, points=points)])
    with open_branches(tmp_path / "stiff.h5") as file:
        table = file["3D-L2"].table
    for name, factor in (("end_tension", 2.0), ("energy_hat", 2.0), ("wetted_length", 1.0)):
        assert np.allclose(
            table[name], [factor * p.values[name] for p in branch.points], rtol=1e-14
        )


def test_bad_files(tmp_path):
    text = tmp_path / "text.h5"
    text.write_text("no HDF5")
    other = tmp_path / "other.h5"
    with h5py.File(other, "w") as file:
        file["x"] = 1
    for path in (text, other, tmp_path / "missing.h5"):
        with pytest.raises(DerodError, match=path.name):
            open_branches(path)


def test_a_failed_write_leaves_the_old_file(tmp_path, branches):
    target = tmp_path / "b.h5"
    write_branches(target, Parameters(), [branches["3D-L2"]])
    before = target.read_bytes()
    with pytest.raises(AttributeError):
        write_branches(target, Parameters(), [None])
    assert target.read_bytes() == before
    assert [p.name for p in tmp_path.iterdir()] == ["b.h5"]


def test_unknown_branch(branch_file):
    with open_branches(branch_file) as file, pytest.raises(KeyError, match="it has Ax"):
        file["Bx"]
