"""Counts of unstable modes: jumps at bifurcations, neutral modes, independence of the mesh."""

import numpy as np
import pytest
from scipy.linalg import eigvalsh

from derod.branches.stability import SecondVariation, unstable_modes


def test_lowest_energy_succession_is_stable(branches):
    """3D, L2 between its two joints, 3D after it: no unstable mode anywhere."""
    for name in ("3D", "3D-L2"):
        inside = branches[name].points[2:-2]
        assert [p.unstable_modes for p in inside] == [0] * len(inside)
    loop = branches["L2"]
    joints = [b.index for b in loop.bifurcations if b.partner.startswith("3D")]
    inside = loop.points[joints[0] + 1 : joints[1]]
    assert len(inside) > 3
    assert [p.unstable_modes for p in inside] == [0] * len(inside)


def test_each_bifurcation_changes_the_flip_even_count_by_one(branches):
    """Folds and the pitchforks located here are flip-symmetric: one even mode each, no odd one."""
    checked = 0
    for name in ("Ax", "L2"):
        branch = branches[name]
        for special in branch.bifurcations:
            i = special.index
            before = unstable_modes(branch.points[i - 1].state, 1.5)
            after = unstable_modes(branch.points[i + 1].state, 1.5)
            neighbours = [b.index for b in branch.bifurcations if abs(b.index - i) == 1]
            if neighbours:
                continue
            assert abs(before[0] - after[0]) == 1, (name, i)
            checked += 1
    assert checked >= 8


def test_ax_is_stable_up_to_its_first_pitchfork_only(branches):
    branch = branches["Ax"]
    first = branch.bifurcations[0].index
    assert {p.unstable_modes for p in branch.points[:first]} == {0}
    assert all(p.unstable_modes >= 1 for p in branch.points[first + 1 :])


def test_neutral_modes_cost_nothing(branches):
    """Turning about the clamp axis, and sliding while the outer rod is long."""
    state = branches["3D"].points[20].state
    for resolution, limit in ((0.8, 1e-4), (1.6, 1e-5)):
        variation = SecondVariation(state, resolution)
        for mode in variation.neutral:
            share = mode @ variation.form @ mode / (mode @ mode)
            assert abs(share) < limit


def test_ritz_values_converge_from_above(branches):
    state = branches["Ax"].points[branches["Ax"].bifurcations[0].index + 4].state
    lowest, counts = [], []
    for resolution in (0.5, 1.0, 2.0):
        form = SecondVariation(state, resolution).restricted(False)
        values = eigvalsh(form)
        lowest.append(values[0] * form.shape[0])
        counts.append(int((values < 0.0).sum()))
    assert counts == [1, 1, 1]


def test_count_is_that_of_the_eigenvalues(branches):
    """Sylvester's count from the factorisation against dense eigenvalues."""
    for i in (5, 40, 70, 100):
        state = branches["Ax"].points[i].state
        variation = SecondVariation(state)
        dense = tuple(int((eigvalsh(variation.restricted(odd)) < 0).sum()) for odd in (False, True))
        assert unstable_modes(state) == dense


def test_pitchfork_mode_is_the_softest(branches):
    """At a pitchfork the form has an eigenvalue that vanishes with the mesh."""
    branch = branches["L2"]
    joint = next(b for b in branch.bifurcations if b.partner == "3D")
    lowest = []
    for resolution in (0.8, 1.6):
        form = SecondVariation(branch.points[joint.index].state, resolution).restricted(False)
        lowest.append(np.abs(eigvalsh(form)).min() * form.shape[0])
    assert lowest[1] < 0.3 * lowest[0]
    assert lowest[1] == pytest.approx(0.0, abs=2e-2)
