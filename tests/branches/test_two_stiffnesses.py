"""Rods with two bending stiffnesses: equations, planar paths, the turn, counts, sections, files."""

from dataclasses import replace
from itertools import pairwise

import h5py
import numpy as np
import pytest
from scipy.integrate import solve_ivp

from derod.branches.files import checking
from derod.branches.files.record import open_branches
from derod.branches.files.writing import write_branches
from derod.branches.half_rod.closure import DELTA, FGAMMA
from derod.branches.half_rod.element import moment
from derod.branches.half_rod.fields import evaluate_fields
from derod.branches.half_rod.gauss import WEIGHTS
from derod.branches.half_rod.linear import linearise
from derod.branches.half_rod.mesh import halved
from derod.branches.half_rod.mirror import FULL, LOOP_EVEN, STRAIGHT_LOOP, STRAIGHT_S
from derod.branches.half_rod.observables import observables
from derod.branches.half_rod.parameters import Parameters
from derod.branches.half_rod.wall_core import cored_wall
from derod.branches.paths.arc import frozen
from derod.branches.paths.catalogue import Catalogue
from derod.branches.paths.compute import family
from derod.branches.paths.newton import settle
from derod.branches.paths.planar_modes import critical_aspect, critical_twisting, planar_modes
from derod.branches.paths.stability import stability
from derod.branches.paths.stiffening import stiffened
from derod.branches.paths.straight import buckling_tensions
from derod.errors import DerodError, SceneError
from derod.files import checks
from derod.scene import build_scene
from tests.branches.conftest import FAST
from tests.branches.dense_stability import SecondVariation, dense_modes, directors
from tests.branches.test_element import CROSSED, SCALARS, SHORT, START, STRIP, shot

SIDEWAYS = 0.5 * np.pi
FIXED = np.stack([frozen(FGAMMA), frozen(DELTA)])
FIGURES = Parameters(wall_strength=2e-2)


@pytest.fixture(scope="module")
def flat():
    """The rod of the figures with K2/K1 = 4: Ax, 3D, L2, 3D-L2."""
    out = Catalogue(replace(FIGURES, bending_2=4.0), FAST)
    out.ax()
    list(out.succession())
    return out


@pytest.fixture(scope="module")
def strip():
    """K2/K1 = 16, bending easily in the plane of Pt."""
    out = Catalogue(replace(FIGURES, bending_2=16.0, director=SIDEWAYS), FAST)
    out.pt()
    return out


# -- the equations


@pytest.mark.parametrize("parameters", [STRIP, CROSSED])
def test_against_the_directors_equations(parameters):
    """r' = d_3, d_i' = U x d_i, U_i = M_i/K_i in the material frame, m' = n x d_3, n' = grad v."""
    state, _ = shot(START, SCALARS, 10, 8, parameters)
    turned = np.array([[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    to_material = turned if parameters.crossed else np.eye(3)
    stiffness = np.array([1.0, parameters.bending_2, parameters.twisting])

    def rate(_, y, wet):
        d, m, n = y[3:12].reshape(3, 3), y[12:15], y[15:]
        own = to_material @ d  # rows d_1, d_2, d_3 of the material
        u = own.T @ (own @ m / stiffness)
        gap = 1.0 + parameters.wall_softness - 2.0 * np.linalg.norm(y[:3])
        push = 2.0 * parameters.wall_strength / gap**2 * y[:3] / np.linalg.norm(y[:3])
        return np.concatenate([d[2], np.cross(u, d).ravel(), np.cross(n, d[2]), push * wet])

    def m_of(node):
        m = np.empty(3)
        moment(SCALARS[0], SCALARS[1], node[:3], node[7:10], m)
        return m

    def start(node):
        frame = directors(node[3:7]).T.ravel()
        return np.concatenate([node[:3], frame, m_of(node), node[7:]])

    def run(node, length, wet):
        options = {"rtol": 1e-12, "atol": 1e-13, "method": "DOP853"}
        return solve_ivp(rate, (0.0, length), start(node), args=(wet,), **options).y[:, -1]

    inner = run(state.nodes[0], SCALARS[3], 1.0)
    assert np.abs(inner - start(state.nodes[state.inner])).max() < 1e-9
    outer = run(state.nodes[state.inner + 1], 0.5 * parameters.length - SCALARS[3], 0.0)
    assert np.abs(outer - start(state.nodes[-1])).max() < 1e-9


def test_what_is_conserved():
    """|q|, and the Hamiltonian m.u/2 + n.d_3 - v; u3 is not uniform."""
    state, _ = shot(START, SCALARS, 8, 8, STRIP)
    assert np.abs(np.linalg.norm(state.nodes[:, 3:7], axis=1) - 1.0).max() < 1e-13
    values, twists = [], []
    for y in state.nodes[: state.inner + 1]:
        m, d = np.empty(3), directors(y[3:7])
        moment(SCALARS[0], SCALARS[1], y[:3], y[7:10], m)
        gap = 1.0 + STRIP.wall_softness - 2.0 * np.linalg.norm(y[:3])
        own = d.T @ m
        energy = 0.5 * np.sum(own**2 / [1.0, STRIP.bending_2, STRIP.twisting])
        values.append(energy + y[7:10] @ d[:, 2] - STRIP.wall_strength / gap)
        twists.append(own[2])
    assert np.ptp(values) < 1e-9
    assert np.ptp(twists) > 1e-4


def test_equal_stiffnesses_are_the_limit(catalogue):
    """K2/K1 = 1 + 1e-7 moves a space state by about as much."""
    state = catalogue.paths["3D"].points[20].state
    before = observables(settle(state, FULL, FIXED, FIXED @ state.kept, 1e-10).state)
    for director in (0.0, SIDEWAYS):
        near = replace(state.parameters, bending_2=1.0 + 1e-7, director=director)
        found = observables(stiffened(state, near, FULL, FAST).state)
        for name in ("end_tension", "energy_hat", "energy_bend", "energy_twist", "wetted_length"):
            assert found[name] == pytest.approx(before[name], abs=1e-5), name


def test_swapped_axes_are_the_same_rod(catalogue):
    """[K1, K2] with d_1 along the flip axis is K1 times [1, K1/K2] of a rod with d_2 there."""
    state = catalogue.paths["3D"].points[20].state
    one = replace(state.parameters, bending_2=2.0, director=SIDEWAYS)
    two = Parameters(
        twisting=0.45, capillary_force=10.0, wall_strength=1e-4, bending_2=0.5, bending=2.0
    )
    first = stiffened(state, one, FULL, FAST).state
    forces = np.tile(np.r_[np.ones(7), np.full(3, 0.5)], (len(first.nodes), 1))
    scalars = first.scalars * [0.5, 0.5, 1.0, 1.0, 1.0, 0.5, 1.0]
    second = replace(first, parameters=two, nodes=first.nodes * forces, scalars=scalars)
    assert linearise(second).residual < 1e-8
    a, b = observables(first), observables(second)
    assert 2.0 * b["energy_total"] == pytest.approx(a["energy_total"], rel=1e-9)
    assert 2.0 * b["energy_twist"] == pytest.approx(a["energy_twist"], rel=1e-9)


# -- planar paths and closed forms


def test_planar_paths_know_neither_k2_nor_k3(branches):
    """Ax and L2 about d_1 solve the equations of every K2 and K3, with the same t and E_hat."""
    for name in ("Ax", "L2"):
        for point in branches[name].points[::15]:
            other = replace(point.state.parameters, bending_2=7.0, twisting=2.5)
            state = point.state.with_parameters(other)
            assert linearise(state).residual < 1e-8
            assert observables(state)["energy_hat"] == pytest.approx(
                point.values["energy_hat"], rel=1e-12
            )


def test_folds_stay_and_pitchforks_move(flat):
    """Ax at K2/K1 = 4: the round rod's folds, one pitchfork, and 3D leaves it backward."""
    found = {
        kind: [s.point.state.end_shortening / np.pi for _, s in flat.paths["Ax"].specials if s.kind == kind]
        for kind in ("fold", "pitchfork")
    }  # fmt: skip
    assert found["fold"] == pytest.approx([1.3286419, 0.6246752], abs=1e-6)
    assert found["pitchfork"] == pytest.approx([0.4513199], abs=1e-6)
    folds = [s.point.state.end_shortening / np.pi for _, s in flat.paths["3D"].specials]
    assert folds == pytest.approx([0.4040721], abs=1e-6)
    assert flat.paths["3D"].ends == "pitchfork of L2"


@pytest.mark.parametrize(("mode", "director"), [(STRAIGHT_LOOP, SIDEWAYS), (STRAIGHT_S, 0.0)])
def test_buckling_about_d2_is_that_of_a_rod_of_stiffness_k2(mode, director):
    """t/K2 is a function of f_gamma/K2 and v0/K2; that one has a closed form (test_straight)."""
    ratio = 2.5
    rod = Parameters(capillary_force=200.0, wall_strength=2e-2, bending_2=ratio, director=director)
    scaled = Parameters(capillary_force=200.0 / ratio, wall_strength=2e-2 / ratio)
    found = buckling_tensions(rod, mode)[0]
    assert found == pytest.approx(ratio * buckling_tensions(scaled, mode)[0], rel=1e-10)


def test_turning_costs_what_bending_in_another_plane_does(flat):
    """phi = e_z - d_3 has phi' = -d_3': its form is (K2 - K1) int kappa^2, K2 about the normal."""
    for ratio in (4.0, 0.5):
        for point in flat.paths["Ax"].points[5:30:8]:
            state = halved(point.state).with_parameters(replace(FIGURES, bending_2=ratio))
            fields = evaluate_fields(state)
            curved = np.sum(fields.moments**2, axis=2)
            wanted = (ratio - 1.0) * np.sum(state.lengths[:, None] * WEIGHTS * curved)
            variation = SecondVariation(state)
            turn = variation.neutral[0]
            assert turn @ variation.form @ turn == pytest.approx(wanted, rel=1e-3)
            if ratio < 1.0:  # bent about the stiffer axis it rolls over
                assert stability(state).odd >= 1


@pytest.mark.parametrize("name", ["3D", "L2", "Ax"])
def test_energy_slope(flat, name):
    """dE_tot/ddelta = -t: the end's work."""
    path = flat.paths[name]
    for point in path.points[4:-4:6]:
        ends = [path.tracer.advance(point, ds, remesh=False).state for ds in (1e-3, -1e-3)]
        a, b, here = *(observables(end) for end in ends), observables(point.state)
        if abs(a["end_shortening"] - b["end_shortening"]) < 1e-4:
            continue
        slope = (a["energy_total"] - b["energy_total"]) / (
            a["end_shortening"] - b["end_shortening"]
        )
        assert slope == pytest.approx(-here["end_tension"], abs=2e-3)


# -- counts


def test_counts_are_those_of_the_dense_form(flat, strip):
    seen = set()
    for path in (*flat.paths.values(), *strip.paths.values()):
        for point in path.points[3:-3:7]:
            state = halved(point.state)
            found = stability(state)
            assert (found.even, found.odd) == dense_modes(state), (path.name, point.arc)
            seen.add((found.even, found.odd))
    assert len(seen) >= 6


def test_the_pitchfork_and_the_fold_change_the_count(flat):
    for name, kind in (("Ax", "pitchfork"), ("3D", "fold")):
        path = flat.paths[name]
        at = next(s for _, s in path.specials if s.kind == kind)
        modes = [
            stability(halved(path.tracer.advance(at.point, ds).state)).even for ds in (-0.1, 0.1)
        ]
        assert sorted(modes) == [0, 1]


def test_planar_counts_add_up(flat, strip):
    for path in (flat.paths["Ax"], strip.paths["Pt"]):
        for point in path.points[3:-3:9]:
            found, whole = planar_modes(point.state), stability(point.state)
            assert found.in_even + found.out_even == whole.even
            assert found.in_odd + found.out_odd == whole.odd
    with pytest.raises(ValueError, match="not planar"):
        planar_modes(flat.paths["3D"].points[8].state)


def on_plateau(strip, delta):
    state = max(strip.paths["Pt"].landings(delta * np.pi), key=lambda s: s.end_tension)
    return halved(halved(state))


def test_the_torsion_that_holds_pt_in_its_plane(strip):
    """Values of runs/two_stiffnesses.py; the dense form agrees on both sides."""
    state = on_plateau(strip, 1.0)
    found = critical_twisting(state, 16.0)
    assert found == pytest.approx(2.324092, abs=1e-4)
    coarse = max(strip.paths["Pt"].landings(np.pi), key=lambda s: s.end_tension)
    for twisting, count in ((found - 0.01, 1), (found + 0.01, 0)):
        stiffer = coarse.with_parameters(replace(coarse.parameters, twisting=twisting))
        assert sum(dense_modes(stiffer)) == count
    assert critical_twisting(state, 4.0) > found
    assert critical_aspect(state, lambda aspect: 4.0 / 3.0) is None
    half = on_plateau(strip, 0.5)
    assert planar_modes(half).in_odd == 1  # breaks the flip symmetry in its plane
    assert critical_aspect(half, lambda aspect: 1.5255, widest=50.0) == pytest.approx(4.0, abs=2e-3)


def test_the_core_of_the_cone(rng):
    """Its value meets the cone with two derivatives, and its Hessian is that of its gradient."""
    grad, hess = np.empty(3), np.empty((3, 3))
    up, down, other = np.empty(3), np.empty(3), np.empty((3, 3))
    for radius in (0.0, 0.003, 0.009, 0.00999999, 0.02):
        w = rng.normal(size=3)
        w *= radius / np.linalg.norm(w)
        cored_wall(w, 0.02, 0.1, 0.01, grad, hess)
        for i in range(3):
            step = np.zeros(3)
            step[i] = 1e-7
            cored_wall(w + step, 0.02, 0.1, 0.01, up, other)
            cored_wall(w - step, 0.02, 0.1, 0.01, down, other)
            assert np.abs((up - down) / 2e-7 - hess[i]).max() < 2e-3


# -- the path of the stiffened rod


def test_the_stiffened_path(strip):
    """Reached from the round rod's 3D: energies slope, ends, and its name."""
    found = list(strip.stiff())
    assert [path.name for path in found] == ["3D-K2"]
    path = found[0]
    state = min((p.state for p in path.points), key=lambda s: abs(s.end_shortening - np.pi))
    assert state.end_shortening == pytest.approx(np.pi, abs=1e-9)  # K2/K1 was raised there
    assert observables(state)["energy_hat"] == pytest.approx(14.62348, abs=1e-4)
    assert stability(halved(state)).modes == 0
    assert family("3D-K2") == "3D"


def test_a_stiffened_path_that_is_known_is_not_traced_again(flat):
    assert list(flat.stiff()) == []
    assert list(Catalogue(FIGURES, FAST).stiff()) == []
    heavy = Catalogue(replace(FIGURES, bending_2=4.0, weight=1.0), FAST)
    assert list(heavy.stiff()) == []
    assert family("S'") == "Pt"


# -- parameters, scenes, files


def test_directors_that_have_no_flip_symmetric_states_are_refused():
    Parameters(director=0.3)  # a round rod has no directors that matter
    Parameters(bending_2=2.0, director=0.3, end_rotation=-0.6)
    assert Parameters(bending_2=2.0, director=SIDEWAYS).crossed
    assert not Parameters(bending_2=2.0, end_rotation=2.0 * np.pi).crossed
    for wrong in ({"director": 0.3}, {"end_rotation": 1.0}, {"twisting": 0.0}, {"bending_2": 0.0}):
        with pytest.raises(ValueError, match="allowed"):
            Parameters(**{"bending_2": 2.0, **wrong})


def scene_with(**changes):
    data = {
        "rod": {"length": 10, "bending": [2.0, 8.0], "twisting": 1.8},
        "drop": {"capillary_force": 40, "wall_strength": 0.04, "wall_softness": 0.1},
        "push": {"stop": 1.0},
        "clamps": {"end_rotation": 0.0},
    }
    for key, value in changes.items():
        table, name = key.split("__")
        data[table][name] = value
    return build_scene(data)


def test_from_a_scene():
    found = Parameters.from_scene(scene_with(), SIDEWAYS)
    assert found == replace(FIGURES, bending=2.0, bending_2=4.0, director=SIDEWAYS)
    for wrong, key in (
        ({"clamps__end_rotation": 1.0}, "end_rotation"),
        ({"rod__twisting": 0}, "twisting"),
    ):
        with pytest.raises(SceneError, match=key):
            Parameters.from_scene(scene_with(**wrong))
    assert Parameters.from_scene(scene_with(rod__bending=[2.0, 2.0])) == replace(
        FIGURES, bending=2.0
    )


def test_files_keep_the_section(tmp_path, flat):
    path = tmp_path / "flat.h5"
    write_branches(path, flat.parameters, [flat.store(flat.paths["3D-L2"])])
    with open_branches(path) as file:
        assert file.parameters == flat.parameters
        branch = file["3D-L2"]
        landing = branch.at(7.5)[0]
        assert landing.unstable_modes == (0, 0)
        for left, right in pairwise(branch.table["energy_twist"]):
            assert left >= 0.0
            assert right >= 0.0
    with h5py.File(path, "r+") as file:  # a section that no rod has
        file.attrs["bending_2"] = -1.0
        file.attrs["check"] = np.uint64(checking.head_check(checks.attributes(file), ["3D-L2"]))
    with pytest.raises(DerodError, match="bending_2"):
        open_branches(path)


def test_files_without_a_section_are_read(tmp_path, branches):
    """Layouts before 4 have one bending stiffness."""
    path = tmp_path / "old.h5"
    write_branches(path, Parameters(), [branches["3D-L2"]])
    with h5py.File(path, "r+") as file:
        del file.attrs["bending_2"], file.attrs["director"]
        file.attrs["format"] = "derod-branches-3"
        file.attrs["check"] = np.uint64(checking.head_check(checks.attributes(file), ["3D-L2"]))
    with open_branches(path) as file:
        assert file.parameters == Parameters()


def test_short_rod_is_the_isotropic_one():
    """The default section asks for no other equations."""
    assert not SHORT.anisotropic
    assert np.array_equal(SHORT.section, [0.9, 1.0, 1.0])
    assert LOOP_EVEN.carries_weight
