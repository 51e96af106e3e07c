"""Paths and special points of the paper's rod (v0 = 2e-4)."""

from dataclasses import replace

import numpy as np
import pytest

from derod.branches.half_rod.closure import DELTA, FGAMMA
from derod.branches.half_rod.linear import Reduced, linearise
from derod.branches.half_rod.mesh import adapted, transferred
from derod.branches.half_rod.mirror import FULL, LOOP_EVEN, LOOP_ODD, PLANES
from derod.branches.half_rod.observables import loops, observables
from derod.branches.half_rod.outcome import NotConverged
from derod.branches.half_rod.parameters import Parameters
from derod.branches.paths.arc import Control, Tracer, frozen
from derod.branches.paths.catalogue import Catalogue
from derod.branches.paths.compute import compute_branches, family
from derod.branches.paths.error import halving_error
from derod.branches.paths.joints import odd_part
from derod.branches.paths.newton import settle
from derod.branches.paths.special import branch_off
from derod.branches.paths.tracing import OUTER_END, collect, special_points

FIXED = np.stack([frozen(FGAMMA), frozen(DELTA)])


def at(branch, kind):
    return [branch.points[b.index].values for b in branch.bifurcations if b.kind == kind]


def test_bifurcation_points_of_the_design(branches):
    """DESIGN.md, section 1: found there by two other solvers."""
    forks = [v["end_shortening"] / np.pi for v in at(branches["3D"], "pitchfork")]
    assert forks == pytest.approx([0.243045, 2.056822], abs=1e-6)
    assert at(branches["3D-L2"], "pitchfork")[0]["end_shortening"] / np.pi == pytest.approx(
        2.256610, abs=1e-6
    )
    assert at(branches["3D"], "pitchfork")[0]["end_tension"] == pytest.approx(12.9116, abs=1e-4)
    assert at(branches["3D"], "pitchfork")[1]["end_tension"] == pytest.approx(19.7332, abs=1e-4)
    assert at(branches["3D-L2"], "pitchfork")[0]["end_tension"] == pytest.approx(16.5582, abs=1e-4)
    assert at(branches["Ax"], "fold")[0]["end_shortening"] / np.pi == pytest.approx(
        1.3312, abs=5e-5
    )


def test_succession_and_partners(branches):
    assert [b.partner for b in branches["3D"].bifurcations] == ["Ax", "L2"]
    assert [b.partner for b in branches["3D-L2"].bifurcations] == ["L2"]
    assert "3D" in [b.partner for b in branches["Ax"].bifurcations]
    assert branches["3D-L2"].ends == "the outer rod ran out"


def test_paths_end_where_the_outer_rod_runs_out(branches):
    for name in ("Ax", "3D-L2"):
        last = branches[name].points[-1]
        assert 5.0 - last.state.sigma == pytest.approx(OUTER_END, abs=1e-9)
    assert branches["3D-L2"].points[-1].values["end_shortening"] / np.pi == pytest.approx(
        2.868, abs=2e-3
    )


def test_every_point_is_accurate_to_its_mesh(branches):
    for branch in branches.values():
        errors = np.array([p.error for p in branch.points])
        assert np.isfinite(errors).all()
        assert errors.max() <= 1e-8, branch.name


def test_work_identity(branches, catalogue):
    """dE_tot/ddelta = -t: Gauss quadrature of t over short stretches of each path.

    Late on Ax the rod passes the wall's cone at the drop's centre: its energy is known to 1e-9 there
    instead of 1e-12, and dividing by the stretch makes 40 of it.
    """
    x, w = np.polynomial.legendre.leggauss(8)
    for name, pick, limit in (
        ("Ax", 12, 1e-10),
        ("Ax", -10, 4e-8),
        ("3D", 20, 1e-10),
        ("L2", 25, 1e-10),
        ("3D-L2", 10, 1e-10),
    ):
        branch = branches[name]
        mirror = branch.even if name != "3D" else FULL
        state = adapted(branch.points[pick].state, 3.5)
        a = state.end_shortening
        b = a + 0.05

        def there(delta, start=state, mirror=mirror):
            values = np.array([20.0, delta])
            return observables(settle(start, mirror, FIXED, values, 1e-11, 16).state)

        work = sum(
            0.5 * (b - a) * wk * there(0.5 * (a + b) + 0.5 * (b - a) * xk)["end_tension"]
            for xk, wk in zip(x, w, strict=True)
        )
        change = there(b)["energy_total"] - there(a)["energy_total"]
        assert change / (b - a) == pytest.approx(-work / (b - a), abs=limit), name


def test_invariants_of_settled_states(branches):
    """Unit quaternions, the middle's flip symmetry, and n_y = 0 outside the drop."""
    for branch in branches.values():
        for point in branch.points[::10]:
            y = point.state.nodes
            assert np.abs(np.linalg.norm(y[:, 3:7], axis=1) - 1.0).max() < 1e-8
            assert np.abs(y[point.state.inner + 1 :, 8]).max() < 1e-8
            assert np.abs(y[0, [0, 2, 4, 6, 8]]).max() < 1e-8


def test_planar_paths_stay_exactly_planar(branches):
    for name in ("Ax", "L2"):
        for point in branches[name].points:
            assert not odd_part(point.state, LOOP_ODD).any()
    assert loops(branches["L2"].points[30].state) == pytest.approx(2.0, abs=1e-6)
    assert loops(branches["Ax"].points[20].state) == pytest.approx(0.0, abs=1e-6)


def test_both_sides_of_a_pitchfork_are_mirror_images(catalogue):
    special = catalogue.ax().specials[0][1]
    right, _ = branch_off(special, 1e-10, 1.0)
    left, _ = branch_off(special, 1e-10, -1.0)
    assert np.allclose(right.state.nodes[:, 0], -left.state.nodes[:, 0], atol=1e-10)
    assert np.allclose(right.state.nodes[:, 1:3], left.state.nodes[:, 1:3], atol=1e-10)
    assert abs(right.state.nodes[:, 0]).max() > 5e-4


def test_located_points_zero_their_test_functions(catalogue):
    for path in catalogue.paths.values():
        for _, special in path.specials:
            assert special.function < 1e-9
            if special.kind == "fold":
                assert abs(special.point.fold_function) < 1e-9


def test_folds_are_seen_in_both_directions(catalogue):
    """Marched backwards over its fold, Ax has the fold at the same place."""
    path = catalogue.ax()
    (i, fold) = next(item for item in path.specials if item[1].kind == "fold")
    tracer = Tracer(LOOP_EVEN, Control(), 20.0)
    start = tracer.begin(path.points[i + 2].settled, -path.points[i + 2].tangent)
    points, reason = collect(
        tracer, start, lambda p: "over" if p.fold_function * start.fold_function < 0.0 else None
    )
    assert reason == "over"
    remarks = []
    found = [s for _, s in special_points(tracer, points, None, remarks)]
    assert not remarks
    assert len(found) == 1
    assert found[0].point.state.end_shortening == pytest.approx(
        fold.point.state.end_shortening, abs=1e-7
    )


def test_collocation_converges_with_its_order(branches):
    """Nodal superconvergence: halving the mesh divides the error by far more than 2^6."""
    state = branches["3D"].points[20].state
    fine = settle(
        adapted(state, 3.0), FULL, FIXED, np.array([20.0, state.end_shortening]), 1e-12, 16
    ).state
    reference = observables(fine)["end_tension"]
    errors = []
    for count in (8, 16):
        eta_in, eta_out = np.full(count, 1 / count), np.full(count, 1 / count)
        coarse = transferred(fine, eta_in, eta_out)
        values = np.array([20.0, state.end_shortening])
        errors.append(
            abs(
                observables(settle(coarse, FULL, FIXED, values, 1e-11, 30).state)["end_tension"]
                - reference
            )
        )
    assert errors[0] / errors[1] > 2**6


def test_the_error_estimate_is_honest(branches):
    """On a coarse mesh the estimate is the distance to the fine solution."""
    state = branches["3D"].points[20].state
    values = np.array([20.0, state.end_shortening])
    exact = observables(settle(adapted(state, 3.0), FULL, FIXED, values, 1e-12, 16).state)
    tracer = Tracer(FULL, Control(), 20.0)
    coarse = settle(adapted(state, 0.6), FULL, FIXED, values, 1e-11, 16).state
    tangent = Reduced(linearise(coarse)).solve(FIXED, np.array([[0.0, 1.0, 0.0]]))[0]
    estimate = halving_error(tracer, coarse, tangent)
    own = observables(coarse)
    true = max(
        abs(own[k] - exact[k]) / max(1.0, abs(exact[k])) for k in ("end_tension", "energy_hat")
    )
    assert estimate > 1e-9
    assert 0.3 * true < estimate < 30.0 * true


def test_a_mesh_without_end_is_refused(branches):
    """A node a hair inside the wall asks for elements without number: an outcome, not a flood."""
    state = branches["3D"].points[20].state
    nodes = state.nodes.copy()
    inside = nodes[1 : state.inner, :3]
    inside *= (0.55 - 1e-13) / np.linalg.norm(inside, axis=1)[:, None]
    with pytest.raises(NotConverged, match=r"asks for|outside the wall"):
        adapted(replace(state, nodes=nodes))


def test_newton_says_when_it_fails(branches):
    state = branches["3D"].points[20].state
    with pytest.raises(NotConverged):
        settle(state, FULL, FIXED, np.array([20.0, state.end_shortening + 2.0]), 1e-10, 8)


def test_a_weak_drop_only_buckles_when_pushed():
    """f_gamma = 0.3 holds the straight rod straight; it buckles under a negative tension."""
    branches, complaints = compute_branches(
        Parameters(capillary_force=0.3), ["Ax"], count_modes=False
    )
    assert not complaints
    assert branches[0].points[0].values["end_tension"] < 0.0
    assert max(p.error for p in branches[0].points) <= 1e-8


def test_end_rotation_leads_to_one_loop():
    """R = 2 pi: the twisted rod's space path meets L1 (DESIGN.md, section 5)."""
    control = Control(tolerance=1e-9, largest_step=0.4, turning=0.4)
    catalogue = Catalogue(Parameters(end_rotation=2.0 * np.pi), control)
    names = [path.name for path in catalogue.succession()]
    assert names == ["3D", "L1", "3D-L1"]
    assert loops(catalogue.paths["L1"].points[40].state) == pytest.approx(1.0, abs=1e-6)


@pytest.mark.parametrize(
    ("name", "head"),
    [("Ax", "Ax"), ("3D", "3D"), ("3D-L2", "3D"), ("L4", "L"), ("L2'", "L"), ("Tri2", "Tri")],
)
def test_names(name, head):
    assert family(name) == head


@pytest.mark.parametrize("name", ["", "ax", "L", "3D2", "Ptt", "Lx", "Tri"])
def test_bad_names(name):
    if name in ("L", "Tri"):
        assert family(name) == name
    else:
        with pytest.raises(ValueError, match="no such path"):
            family(name)


def test_a_step_onto_a_planar_path_is_refused():
    """A scene on which version 0.1 stepped from 3D onto L2 before their joint, and stored L2's states."""
    own = Parameters(
        length=8.452098,
        twisting=0.845,
        capillary_force=26.737,
        wall_strength=9.38e-4,
        wall_softness=0.119,
    )
    branches, _ = compute_branches(own, ["3D"], count_modes=False)
    path = next(b for b in branches if b.name == "3D")
    sizes = [
        min(np.linalg.norm(odd_part(p.state, odd)) for _, odd in PLANES) for p in path.points[1:-1]
    ]
    assert min(sizes) > 1e-4
    assert path.ends == "pitchfork of L2"
