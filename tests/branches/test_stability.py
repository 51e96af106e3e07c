"""Counts of unstable modes: against the dense form, at bifurcations, sliding, other meshes."""

import numpy as np
import pytest
from scipy.linalg import eigvalsh

from derod.branches.half_rod.front import eliminate, negative_eigenvalues
from derod.branches.half_rod.mesh import adapted, halved
from derod.branches.paths.stability import CLAMP_MOMENT, stability, unstable_modes
from tests.branches.dense_stability import SecondVariation, dense_modes


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
            before = unstable_modes(halved(branch.points[i - 1].state))
            after = unstable_modes(halved(branch.points[i + 1].state))
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


def test_counts_are_those_of_the_dense_form(branches):
    """Even and odd, on the state's own mesh and on another; by dense eigenvalues too."""
    seen = set()
    for branch in branches.values():
        special = {b.index for b in branch.bifurcations}
        beside = {i + k for i in special for k in (-1, 0, 1)}
        for i in range(len(branch.points)):
            if i in beside or i % 3:
                continue
            state = branch.points[i].state
            found = stability(state)
            assert (found.even, found.odd) == dense_modes(state), (branch.name, i)
            coarse = adapted(state, 0.9)
            other = stability(coarse)
            assert (other.even, other.odd) == dense_modes(coarse) == (found.even, found.odd)
            seen.add((found.even, found.odd))
    assert len(seen) >= 8
    form = SecondVariation(state).restricted(True)
    assert found.odd == (eigvalsh(form) < 0.0).sum()


def test_sliding_stiffness_is_that_of_the_dense_form(branches):
    for name in ("Ax", "L2", "3D-L2"):
        for point in branches[name].points[-8:]:
            dense = SecondVariation(point.state).sliding_stiffness()
            assert stability(point.state).sliding_stiffness == pytest.approx(
                dense, rel=1e-3
            )  # its penalties'


def test_sliding_stiffness_of_a_long_outer_rod(branches):
    """About 2 |m|^2 sqrt(t): the clamps' boundary layers, up to what moving the drop sideways costs.

    The latter is a share of about 1/(sqrt(t) outer length).
    """
    ratios = []
    for name in ("Ax", "L2", "3D-L2"):
        for point in branches[name].points:
            state = halved(halved(point.state))
            found = stability(state)
            root = np.sqrt(max(state.end_tension, 0.0))
            decay = root * (0.5 * state.parameters.length - state.sigma)
            if decay > 3.0 and found.clamp_moment > 0.08:
                ratios.append(found.sliding_stiffness / (2.0 * found.clamp_moment**2 * root))
    assert len(ratios) >= 3
    assert min(ratios) > 0.75
    assert max(ratios) < 1.35


def test_sliding_counts_where_it_is_resolved_and_downhill(branches):
    """At the end of 3D-L2 the drop slides: held in place the rod is stable."""
    last = stability(branches["3D-L2"].points[-1].state)
    assert (last.even, last.odd) == (0, 0)
    assert last.sliding_stiffness < 0.0
    assert last.clamp_moment > CLAMP_MOMENT
    assert last.slides
    assert unstable_modes(branches["3D-L2"].points[-1].state) == (0, 1)
    assert branches["3D-L2"].points[-1].unstable_modes == 1
    early = stability(branches["3D"].points[5].state)
    assert early.clamp_moment < 1e-4
    assert not early.slides


def test_at_special_points_the_neutral_mode_is_left_out(branches):
    """The count there is the lower one of its two sides'."""
    checked = 0
    for name in ("Ax", "L2"):
        branch = branches[name]
        marked = {b.index for b in branch.bifurcations}
        for i in marked:
            if {i - 1, i + 1} & marked:
                continue
            sides = [branch.points[k].unstable_modes for k in (i - 1, i + 1)]
            assert branch.points[i].unstable_modes == min(sides), (name, i)
            checked += 1
    assert checked >= 8


def test_elimination_keeps_the_inertia(rng):
    """Random indefinite matrices, some with zero diagonals: pivots + rest = dense eigenvalues."""
    for trial in range(200):
        n = 12
        a = rng.normal(size=(n, n))
        a += a.T
        if trial % 2:
            np.fill_diagonal(a, 0.0)
        wanted = int((np.linalg.eigvalsh(a) < 0.0).sum())
        left = a.copy()
        negative = eliminate(left, 2, 8, np.empty(n))
        keep = [0, 1, 8, 9, 10, 11]
        assert not np.delete(left, keep, axis=0).any()
        assert negative + negative_eigenvalues(left[np.ix_(keep, keep)]) == wanted
        block = a[2:8, 2:8]
        schur = a[np.ix_(keep, keep)] - a[np.ix_(keep, range(2, 8))] @ np.linalg.solve(
            block, a[np.ix_(range(2, 8), keep)]
        )
        assert left[np.ix_(keep, keep)] == pytest.approx(schur, rel=1e-6, abs=1e-6)


def test_a_singular_block_is_refused():
    left = np.zeros((6, 6))
    left[0, 0] = 1.0
    assert eliminate(left, 1, 4, np.empty(6)) == -1
    with pytest.raises(ValueError, match="not finite"):
        negative_eigenvalues(np.full((2, 2), np.nan))


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
