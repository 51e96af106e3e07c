"""A drop with weight: force balance, energy slopes, turning, counts, files, landings."""

from dataclasses import replace
from pathlib import Path

import h5py
import msgspec
import numpy as np
import pytest

from derod.branches import Parameters, heavy_states
from derod.branches.files import checking
from derod.branches.files.compare import check_same_rod, shape_distance
from derod.branches.files.record import open_branches
from derod.branches.files.writing import write_branches
from derod.branches.half_rod import closure as col
from derod.branches.half_rod.fields import evaluate_fields
from derod.branches.half_rod.gauss import WEIGHTS
from derod.branches.half_rod.mesh import adapted, halved
from derod.branches.half_rod.mirror import FULL, LOOP_EVEN, S_EVEN, planes
from derod.branches.half_rod.observables import observables
from derod.branches.half_rod.outcome import NotConverged
from derod.branches.half_rod.symmetry import half_turned, images
from derod.branches.paths.arc import Control, frozen
from derod.branches.paths.catalogue import Catalogue
from derod.branches.paths.compute import compute_branches, family
from derod.branches.paths.landing import states_at
from derod.branches.paths.newton import settle
from derod.branches.paths.path import PathNotFound
from derod.branches.paths.stability import stability
from derod.branches.paths.weight import FIXED, hung, loaded
from derod.errors import SceneError
from derod.files import checks
from derod.scene import load_scene
from tests.branches.dense_stability import SecondVariation, dense_modes

FAST = Control(tolerance=1e-9, largest_step=0.4, turning=0.4)
HEAVY = Parameters(wall_strength=2e-2, weight=2.0)
HELD = np.stack([frozen(col.FGAMMA), frozen(col.DELTA)])


@pytest.fixture(scope="module")
def heavy():
    """All paths of the figures' rod with W = 2, by name."""
    branches, complaints = compute_branches(HEAVY, control=FAST)
    assert not complaints
    return {branch.name: branch for branch in branches}


@pytest.fixture(scope="module")
def heavy_file(tmp_path_factory, heavy):
    path = tmp_path_factory.mktemp("heavy") / "heavy.h5"
    write_branches(path, HEAVY, list(heavy.values()))
    return path


def test_names(heavy):
    assert {"Ax", "3D", "L2", "3D-L2", "Ax-up", "3D-up", "L2-up"} <= set(heavy)
    assert heavy["Ax"].points[0].values["drop_y"] < 0.0
    assert [b.partner for b in heavy["3D"].bifurcations] == ["Ax", "L2"]
    assert [b.partner for b in heavy["3D-up"].bifurcations] == ["Ax-up", "L2-up"]
    assert family("3D-L2-up") == "3D"
    assert family("Ax-up") == "Ax"
    assert not any(name.startswith("Pt") for name in heavy)


def test_each_clamp_carries_half_of_the_drop(heavy):
    """equa:saut_global in the half rod: n_y = W/2 outside the drop, 0 at the rod's middle."""
    for branch in heavy.values():
        for point in branch.points[::10]:
            y = point.state.nodes
            assert np.abs(y[point.state.inner + 1 :, 8] - 1.0).max() < 1e-8
            assert np.abs(y[0, [0, 2, 4, 6, 8]]).max() < 1e-8


def test_menisci_and_wall_carry_the_drop(heavy):
    """equa:cequivient-de-la-goutte along e_y: sum F (R_C - R)/R = -W + int dv/dy."""
    for name in ("Ax", "3D", "L2-up"):
        state = heavy[name].points[15].state
        values = observables(state)
        fields = evaluate_fields(state)
        weights = state.lengths[: state.inner, None] * WEIGHTS
        wall = 2.0 * np.sum(weights * fields.rates[: state.inner, :, 8])
        menisci = -4.0 * values["meniscus_force"] * state.nodes[state.inner, 1]
        assert menisci == pytest.approx(-state.weight + wall, abs=1e-8), name


def test_a_drop_on_a_taut_rod_hangs_as_on_a_string(heavy):
    """At small end-shortening the outer rod sinks by W/2t per length, but for its boundary layer."""
    first = heavy["Ax"].points[0].state
    assert first.end_tension > 70.0
    slope = 0.5 * first.weight / first.end_tension
    outer = 0.5 * first.parameters.length - first.sigma - 1.0 / np.sqrt(first.end_tension)
    sunk = first.nodes[-1, 1] - first.nodes[first.inner, 1]
    assert sunk == pytest.approx(slope * outer, rel=0.02)
    assert observables(first)["drop_y"] < -sunk  # the drop hangs below its menisci


@pytest.mark.parametrize(("name", "pick"), [("Ax", 40), ("Ax-up", -40), ("3D", 12), ("L2", 40)])
def test_energy_slope_in_delta(heavy, name, pick):
    """dE_tot/ddelta = -t also with a weight: Gauss quadrature of t along a short stretch."""
    x, w = np.polynomial.legendre.leggauss(8)
    mirror = heavy[name].even
    state = adapted(heavy[name].points[pick].state, 3.5)
    a, span = state.end_shortening, 0.02

    def there(delta):
        return observables(settle(state, mirror, HELD, np.array([20.0, delta]), 1e-11, 16).state)

    tensions = [there(a + 0.5 * span * (1.0 + k))["end_tension"] for k in x]
    change = there(a + span)["energy_total"] - there(a)["energy_total"]
    assert change / span == pytest.approx(-0.5 * w @ tensions, abs=1e-8)
    hat = there(a + span)["energy_hat"] - there(a)["energy_hat"]
    assert hat / span == pytest.approx(20.0 - 0.5 * w @ tensions, abs=1e-8)


@pytest.mark.parametrize(("name", "pick"), [("Ax", 40), ("Ax-up", -40), ("3D", 12), ("L2", 40)])
def test_energy_slope_in_the_weight(heavy, name, pick):
    """dE/dW = y_C at fixed end-shortening: settles the sign of n_y = W/2."""
    x, w = np.polynomial.legendre.leggauss(8)
    mirror = heavy[name].even
    state = adapted(heavy[name].points[pick].state, 3.5)
    span = 0.05

    def there(weight):
        values = np.array([state.end_shortening, 20.0, weight])
        return observables(settle(state, mirror, FIXED, values, 1e-11, 16).state)

    places = [there(2.0 + 0.5 * span * (1.0 + k))["drop_y"] for k in x]
    change = there(2.0 + span)["energy_hat"] - there(2.0)["energy_hat"]
    assert change / span == pytest.approx(0.5 * w @ places, abs=1e-8)
    assert abs(change) > 1e-4


def test_the_weight_taken_away_again(catalogue):
    """Loaded and unloaded: the weightless state comes back, to the tolerance."""
    path = catalogue.ax()
    light = path.points[12].state
    state = hung(light, path.points[0].state)
    there = loaded(state, 1.5, LOOP_EVEN, FAST)[0].state
    assert there.weight == pytest.approx(1.5, abs=1e-9)
    assert there.end_shortening == pytest.approx(light.end_shortening, abs=1e-9)
    values = np.array([there.end_shortening, 20.0, 0.0])
    back = settle(there, LOOP_EVEN, FIXED, values, 1e-11, 30).state
    own, other = observables(light), observables(back)
    for name in ("end_tension", "energy_hat", "wetted_length"):
        assert own[name] == pytest.approx(other[name], abs=1e-7)
    assert own["drop_y"] == pytest.approx(-other["drop_y"], abs=1e-7)


def test_turned_by_pi_the_weight_pulls_the_other_way(heavy):
    state = heavy["3D"].points[12].state
    turned = half_turned(state)
    assert turned.weight == -2.0
    settled = settle(turned, FULL, FIXED, FIXED @ turned.kept, 1e-9, 0)
    own, other = observables(state), observables(settled.state)
    assert other["energy_hat"] == pytest.approx(own["energy_hat"], abs=1e-12)
    assert other["drop_y"] == -own["drop_y"]
    assert len(images(state.kept)) == 4
    assert len(images(state.set_scalar(col.WEIGHT, 0.0).kept)) == 8


def test_a_point_symmetric_curve_carries_nothing():
    assert not S_EVEN.carries_weight
    assert len(planes(1.0)) == 2
    assert len(planes(0.0)) == 3
    _, complaints = compute_branches(HEAVY, ["Pt"], count_modes=False)
    assert complaints
    assert complaints[0].startswith("Pt")


@pytest.mark.parametrize("name", ["Ax", "3D", "L2-up"])
def test_turning_costs_what_the_drop_is_lifted(heavy, name):
    """The exact second variation of the turn by a is -W y_C a^2/2 for the whole rod."""
    for point in heavy[name].points[10:40:6]:
        expected = -0.5 * 2.0 * point.values["drop_y"]  # half of the rod: x.F x = k a^2/2
        errors, state = [], point.state
        for _ in range(2):
            state = halved(state)
            variation = SecondVariation(state)
            turn = variation.neutral[0]
            errors.append(abs(turn @ variation.form @ turn - expected))
        assert errors[0] < 1e-4
        assert errors[1] < 0.5 * errors[0]  # the turn is interpolated


def test_counts_are_those_of_the_dense_form(heavy):
    seen = set()
    for branch in heavy.values():
        marked = {b.index + k for b in branch.bifurcations for k in (-1, 0, 1)}
        for i in range(0, len(branch.points), 9):
            if i in marked:
                continue
            state = branch.points[i].state
            found = stability(state)
            assert (found.even, found.odd) == dense_modes(halved(state)), (branch.name, i)
            seen.add((found.even, found.odd))
    assert len(seen) >= 8


def test_counts_do_not_depend_on_the_mesh(heavy):
    for name in ("Ax", "3D", "L2-up"):
        branch = heavy[name]
        marked = {b.index + k for b in branch.bifurcations for k in (-1, 0, 1)}
        for i in range(1, len(branch.points), 5):
            if i not in marked:
                state = branch.points[i].state
                a, b = stability(state), stability(halved(state))
                assert (a.even, a.odd, a.slides) == (b.even, b.odd, b.slides), (name, i)


def test_sliding_is_that_of_a_bead_on_a_string(heavy):
    """Taut and hanging: k = -W y_C (2/(l - delta))^2 up to the rod's stiffness and the drop's size."""
    state = heavy["Ax"].points[5].state
    values, found = observables(state), stability(state)
    half = 0.5 * (state.parameters.length - state.end_shortening)
    assert values["end_tension"] > 30.0
    assert found.sliding_stiffness == pytest.approx(-2.0 * values["drop_y"] / half**2, rel=0.5)
    assert found.sliding_error < 0.05 * found.sliding_stiffness
    assert not found.slides


def test_a_hanging_coil_loses_its_stability_to_rolling(heavy):
    """Flip-odd, where y_C of the weightless coil crosses the clamp axis; y_C itself stays negative."""
    points = heavy["3D"].points[2:-2]
    modes = [p.unstable_modes for p in points]
    assert modes[0] == 0
    assert modes[-1] == 1
    last = stability(points[-1].state)
    assert (last.even, last.odd) == (0, 1)
    assert points[-1].values["drop_y"] < 0.0


def test_files_and_landings(heavy_file, heavy):
    with open_branches(heavy_file) as file:
        assert file.parameters == HEAVY
        branch = file["3D"]
        assert branch.state(5).weight == 2.0
        assert np.array_equal(
            branch.table["drop_y"], [p.values["drop_y"] for p in heavy["3D"].points]
        )
        landing = branch.at(0.5 * np.pi)[0]
        planar = file["Ax"].at(1.0 * np.pi)
    assert landing.state.weight == 2.0
    assert landing.tension_error < 1e-8
    assert len(planar) == 3
    found = heavy_states(HEAVY, [0.5 * np.pi], paths=("Ax", "3D"))[0.5 * np.pi]
    own = [one for one in found if one.origin == "3D"]
    assert len(own) == 1
    assert not own[0].planar
    for name in ("end_tension", "energy_hat", "drop_y", "wetted_length"):
        assert own[0].values[name] == pytest.approx(landing.values[name], abs=1e-7)
    assert own[0].stability.modes == sum(landing.unstable_modes) == 0
    assert landing.values["end_tension"] == pytest.approx(18.4008101, abs=1e-6)
    assert landing.values["energy_hat"] == pytest.approx(10.0729127, abs=1e-6)
    assert landing.values["drop_y"] == pytest.approx(-0.3420088, abs=1e-6)


def test_files_without_a_weight_are_read(tmp_path, branches):
    """Layouts 1 and 2 have no weight among the parameters: it is 0."""
    path = tmp_path / "old.h5"
    write_branches(path, Parameters(), [branches["3D-L2"]])
    with h5py.File(path, "r+") as file:
        del file.attrs["weight"]
        file.attrs["format"] = "derod-branches-2"
        check = checking.head_check(checks.attributes(file), list(file["branches"]))
        file.attrs["check"] = np.uint64(check)
    with open_branches(path) as file:
        assert file.parameters == Parameters()
        assert file["3D-L2"].state(3).weight == 0.0


def test_runs_of_another_weight_are_refused(heavy_file):
    class Run:
        scene = None

    with open_branches(heavy_file) as file, pytest.MonkeyPatch.context() as patch:
        light = classmethod(lambda cls, scene: HEAVY.with_weight(0.0))
        patch.setattr(Parameters, "from_scene", light)
        with pytest.raises(SceneError, match="weight"):
            check_same_rod(Run(), file)


def test_shapes_are_not_turned_under_a_weight(rng):
    curve = rng.normal(size=(50, 3))
    turned = curve * [-1.0, -1.0, 1.0]
    assert shape_distance(curve, turned) < 1e-13
    assert shape_distance(curve, turned, turned=False) > 0.1
    assert shape_distance(curve, curve * [-1.0, 1.0, 1.0], turned=False) == 0.0


def test_a_shallow_rod_cannot_bear_much_upside_down():
    """At delta = 0.05 pi the upside-down sheet folds before W = 5."""
    path = Catalogue(HEAVY.with_weight(0.0), FAST).ax()
    start = min(path.points, key=lambda p: abs(p.state.end_shortening - 0.05 * np.pi)).state
    values = np.array([20.0, 0.05 * np.pi])
    state = settle(start, LOOP_EVEN, HELD, values, 1e-10, 16).state
    with pytest.raises(NotConverged, match="could not be raised to 5"):
        loaded(hung(state, state, upside_down=True), 5.0, LOOP_EVEN, FAST)


def test_twisted_ends(heavy):
    """R = 2 pi: the twisted rod's space path with a weight, up to its loop."""
    own = replace(HEAVY, end_rotation=2.0 * np.pi)
    catalogue = Catalogue(own, FAST)
    names = [path.name for path in catalogue.succession()]
    assert names[:2] == ["3D", "L1"]
    first = catalogue.paths["3D"].points
    assert all(p.state.weight == pytest.approx(2.0, abs=1e-9) for p in first)


def test_a_drop_without_weight_has_no_heavy_states():
    with pytest.raises(PathNotFound, match="without weight"):
        heavy_states(Parameters(), [1.0])


def test_states_at_are_on_all_sheets(heavy_file):
    with open_branches(heavy_file) as file:
        found = states_at(file["Ax-up"], 1.0 * np.pi)
    assert len(found) >= 3
    assert {round(one.values["drop_y"], 3) for one in found} >= {-0.142}


def test_the_scenes_weight_is_divided_by_the_stiffness():
    scene = load_scene(Path(__file__).parents[2] / "runs" / "paper-figures.toml")
    own = msgspec.structs.replace
    drop = own(scene.require_drop(), weight=0.5)
    heavy_scene = own(scene, rod=own(scene.rod, bending=2.0), drop=drop)
    assert Parameters.from_scene(heavy_scene).weight == 0.25
    assert Parameters.from_scene(scene) == Parameters(wall_strength=2e-2)
