"""Points of designs, and what a plan refuses."""

from __future__ import annotations

import itertools
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import derod
from derod.errors import SceneError
from derod.sweeps.plan import make_plan, plan_of_text, read_plan
from tests.scenes import coil

FORCE, LENGTH = "drop.capillary_force", "rod.length"


def test_a_grid_has_every_combination_with_the_last_key_fastest() -> None:
    plan = make_plan(coil(), {FORCE: {"from": 10, "to": 40, "count": 4}, LENGTH: [8, "10"]})
    wanted = list(itertools.product([10.0, 20.0, 30.0, 40.0], [8.0, 10.0]))
    assert list(plan.points()) == wanted and plan.count == 8
    assert plan.changes(wanted[3]) == {FORCE: 20.0, LENGTH: 10.0}


def test_a_list_takes_values_together() -> None:
    plan = make_plan(coil(), {FORCE: [10, 20], LENGTH: np.array([8.0, 9.0])}, design="list")
    assert list(plan.points()) == [(10.0, 8.0), (20.0, 9.0)]


def test_a_logarithmic_range_has_equal_ratios_and_its_ends() -> None:
    spread = {"from": 1e-4, "to": 1e-1, "count": 4, "spacing": "log"}
    values = [x for (x,) in make_plan(coil(), {"drop.wall_strength": spread}).points()]
    assert values[0] == 1e-4 and values[-1] == 1e-1
    assert np.diff(np.log(values)) == pytest.approx(np.log(10.0))


def test_keys_that_count_take_whole_numbers() -> None:
    plan = make_plan(coil(), {"mesh.edges": {"from": 20, "to": 61, "count": 3}})
    assert [x for (x,) in plan.points()] == [20, 40, 61]
    assert all(isinstance(x, int) for (x,) in plan.points())


@pytest.mark.parametrize("design", ["latin-hypercube", "sobol"])
def test_samples_fill_every_share_and_follow_their_distributions(design: str) -> None:
    keys = {FORCE: {"from": 10, "to": 40}, LENGTH: {"normal": [10.0, 0.5]}}
    plan = make_plan(coil(), keys, design=design, points=64, seed=3)
    forces, lengths = np.array(list(plan.points())).T
    bins = np.floor((forces - 10.0) / 30.0 * 64).astype(int)
    assert sorted(bins) == list(range(64))  # one in each of 64 parts: both designs are stratified
    assert lengths.mean() == pytest.approx(10.0, abs=0.02)
    assert lengths.std() == pytest.approx(0.5, rel=0.1)
    again = make_plan(coil(), keys, design=design, points=64, seed=3)
    other = make_plan(coil(), keys, design=design, points=64, seed=4)
    assert list(again.points()) == list(plan.points()) != list(other.points())


def test_uncertain_measured_quantities_are_distributions() -> None:
    scene = derod.Scene("tpu-fibre")
    plan = make_plan(
        scene, {"material.diameter": "5.6 +- 0.5 um"}, design="latin-hypercube", points=50
    )
    values = np.array([x for (x,) in plan.points()])
    assert values.mean() == pytest.approx(5.6e-6, rel=0.01)
    assert values.std() == pytest.approx(0.5e-6, rel=0.1)
    assert scene.replace(plan.changes((5e-6,))).rod.bending == 1.0


SPREADS = st.one_of(
    st.lists(st.floats(1.0, 100.0), min_size=1, max_size=5),
    st.builds(
        lambda low, high, count, log: {
            "from": low,
            "to": high,
            "count": count,
            "spacing": "log" if log else "linear",
        },
        st.floats(1.0, 10.0),
        st.floats(11.0, 100.0),
        st.integers(1, 6),
        st.booleans(),
    ),
)


@settings(max_examples=40, deadline=None)
@given(forces=SPREADS, lengths=SPREADS, seed=st.integers(0, 2**63 - 1))
def test_the_text_of_a_plan_gives_it_back(forces: Any, lengths: Any, seed: int) -> None:
    plan = make_plan(coil(), {FORCE: forces, "drop.weight": lengths}, seed=seed, rows="all")
    again = plan_of_text(plan.text, "x")
    assert again.text == plan.text and list(again.points()) == list(plan.points())
    assert again.scene == plan.scene


def test_the_text_of_a_sampled_plan_gives_it_back() -> None:
    plan = make_plan(
        coil(), {FORCE: {"from": 10, "to": 40, "count": 3}}, design="sobol", points=10, seed=1
    )
    assert list(plan_of_text(plan.text, "x").points()) == list(plan.points())


@pytest.mark.parametrize(
    ("keys", "options", "told"),
    [
        ({"drop.force": [1]}, {}, "drop.force is no key of a scene"),
        ({FORCE: [10, -1]}, {}, r"drop.capillary_force\[1\] = -1 is out of range"),
        ({FORCE: []}, {}, "is no spread of values; allowed: a list of values"),
        ({FORCE: {"from": 10}}, {}, "drop.capillary_force.to is missing"),
        ({FORCE: {"from": 1, "to": 2, "number": 2}}, {}, "drop.capillary_force.number = 2 is unk"),
        ({FORCE: {"from": 1, "to": 2, "count": -2}}, {}, "count = -2 is no number of values"),
        ({FORCE: {"from": 1, "to": 2, "count": 2, "spacing": "x"}}, {}, "spacing = 'x' is no spa"),
        ({FORCE: {"normal": [1, 0]}}, {}, r"normal\[1\] = 0 is out of range"),
        ({"push.at": [1, 2]}, {}, "push.at holds a list"),
        ({FORCE: {"from": 1, "to": 2}}, {}, "has no values for a grid"),
        ({FORCE: [1, 2]}, {"design": "sobol", "points": 4}, "is a list, of which sobol cannot"),
        ({FORCE: {"from": 1, "to": 2}}, {"design": "sobol"}, "design.points is no number of po"),
        ({FORCE: [1, 2]}, {"points": 4}, "design.points = 4 is given, and the grid has its own"),
        ({FORCE: [1, 2]}, {"design": "cube"}, "design.kind = 'cube' is no design; allowed: grid,"),
        ({FORCE: [1, 2], LENGTH: [8]}, {"design": "list"}, "lists of different lengths"),
        ({FORCE: [1, 2]}, {"rows": "first"}, "table.rows = 'first' are no rows"),
        ({FORCE: [1, 2]}, {"rows": "landings"}, "asks for landings, and the scene has none"),
        ({FORCE: [1, 2]}, {"seed": -1}, "design.seed = -1 is no seed"),
        ({}, {}, "keys is empty: nothing varies"),
    ],
)
def test_what_makes_no_sweep_is_refused(keys: Any, options: Any, told: str) -> None:
    with pytest.raises(SceneError, match=told):
        make_plan(coil(), keys, **options)


def test_a_sweep_file_is_read(tmp_path: Path) -> None:
    (tmp_path / "rod.toml").write_text(coil().text)
    file = tmp_path / "sweep.toml"
    file.write_text(
        'scene = "rod.toml"\n[set]\n"mesh.edges" = 50\n'
        '"push.at" = {from = "0.1 pi", to = "0.3 pi", count = 3}\n'
        '[keys]\n"drop.capillary_force" = {from = 10, to = 20}\n'
        '[design]\nkind = "sobol"\npoints = 4\nseed = 2\n[table]\nrows = "landings"\n'
    )
    plan = read_plan(file)
    assert plan.scene.mesh.edges == 50 and plan.count == 4 and plan.rows == "landings"
    assert plan.scene.push.at == pytest.approx(np.pi * np.array([0.1, 0.2, 0.3]))


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("keys = 3", "keys = 3 is not a table"),
        ('scene = "quick"', "keys is missing"),
        ('scene = "quick"\n[keys]\n[desing]\n', "desing is unknown; allowed: scene, set, keys"),
        ('scene = "quick"\n[keys]\n[design]\nnumber = 1\n', "design.number = 1 is unknown"),
        ('scene = "nowhere"\n[keys]\n', "cannot be read"),
        ('scene = "quick"\n[set]\n"rod.length" = {from = 1}\n[keys]\n', "is a range"),
        ("scene =", "cannot be read as a sweep"),
    ],
)
def test_a_bad_sweep_file_is_named(tmp_path: Path, text: str, told: str) -> None:
    file = tmp_path / "sweep.toml"
    file.write_text(text)
    with pytest.raises(SceneError, match=told):
        read_plan(file)
