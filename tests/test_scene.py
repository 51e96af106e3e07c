"""Scene files: what they may say, and how a wrong one is answered."""

from __future__ import annotations

import json
import math
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

import derod
from derod.errors import SceneError
from derod.scene import (
    Scene,
    build_scene,
    dimensionless_groups,
    dump_scene,
    load_scene,
    parse_scene,
)
from derod.scene.directors import check_pushable
from derod.scene.plain import plain_tables
from derod.scene.plan import ROW_BYTES, check_plan, planned
from derod.scene.quantities import read_quantity, write_quantity
from derod.scene.rules import KEYS, QUANTITIES
from tests.scenes import coil

RUNS = sorted((Path(__file__).parent.parent / "runs").glob("*.toml"))
ALL_KEYS = [(table, name) for table, keys in KEYS.items() for name in keys]
BASE: dict[str, dict[str, Any]] = {
    "rod": {"length": 10.0, "bending": 1.0, "twisting": 0.9},
    "drop": {"capillary_force": 20.0, "wall_strength": 2e-4, "wall_softness": 0.1},
    "push": {"stop": "0.4 pi"},
}
REQUIRED = [(table, name) for table, keys in BASE.items() for name in keys]


def with_value(table: str, name: str, value: Any) -> dict[str, dict[str, Any]]:
    data: dict[str, Any] = {key: dict(values) for key, values in BASE.items()}
    if table == "steps":
        data["steps"] = [{"control": "end_rotation", "stop": 1.0, name: value}]
        return data
    data.setdefault(table, {})[name] = value
    return data


def error_of(data: dict[str, Any]) -> SceneError:
    with pytest.raises(SceneError) as caught:
        build_scene(data, "some.toml")
    return caught.value


def bare(key: str | None) -> str:
    """A key without numbers of list items."""
    return "" if key is None else re.sub(r"\[\d+\]", "", key)


def names_all(error: SceneError, key: str) -> bool:
    """Whether the one line names the file, the key, the value and what is allowed."""
    line = str(error)
    return (
        line.startswith("some.toml: ")
        and "\n" not in line
        and error.key is not None
        and bare(error.key) == key
        and f" {error.key} = " in line
        and error.allowed is not None
        and f"; allowed: {' '.join(error.allowed.split())}" in line
    )


def test_all_scenes_that_are_shipped_load() -> None:
    assert {path.name for path in RUNS} >= {"paper-text.toml", "paper-figures.toml", "quick.toml"}
    for path in RUNS:
        scene = load_scene(path)
        assert scene.path == str(path)
        assert parse_scene(scene.text) == scene


def test_the_papers_scene_says_what_the_paper_does() -> None:
    scene = load_scene(next(path for path in RUNS if path.name == "paper-text.toml"))
    assert scene.rod.length == 10.0 and scene.rod.twisting == 0.9
    assert scene.drop is not None and scene.drop.wall_strength == 2e-4
    assert scene.push.stop == (2.8 * math.pi,)
    assert scene.push.at[0] == 0.1 * math.pi and len(scene.push.at) == 8
    assert scene.mesh.edges == 200 and scene.noise.amplitude == 1e-3


# -- wrong values

WRONG: dict[str, list[Any]] = {
    "number": [
        "ten",
        "",
        "pi pi",
        True,
        None,
        [],
        {},
        math.nan,
        math.inf,
        -math.inf,
        10**400,
        -1.0,
    ],
    "integer": [1.5, "12", True, None, [12], {}, math.nan, -1, 10**30],
}
IS_INTEGER = {("mesh", "edges"), ("noise", "seed"), ("model", "dimension")}
MAY_BE_NEGATIVE = {
    ("rod", "natural_twist"),
    ("clamps", "end_rotation"),
    ("clamps", "end_tension"),
    ("steps", "stop"),
}
IS_LIST = {("push", "at"), ("steps", "at")}
IS_SWITCH = {("model", "drop"), ("push", "locate")}


@pytest.mark.parametrize(("table", "name"), ALL_KEYS, ids=lambda part: part)
def test_each_key_refuses_values_of_the_wrong_kind(table: str, name: str) -> None:
    kind = "integer" if (table, name) in IS_INTEGER else "number"
    for value in WRONG[kind]:
        if (table, name) in MAY_BE_NEGATIVE and value == -1.0:
            continue
        if (table, name) in IS_LIST and value == []:
            continue
        if (table, name) in IS_SWITCH and value is True:
            continue
        error = error_of(with_value(table, name, value))
        if value is None:  # cannot be written in TOML; the line has nothing to show
            assert bare(error.key) == f"{table}.{name}"
        else:
            assert names_all(error, f"{table}.{name}"), (value, str(error))


@pytest.mark.parametrize(
    ("table", "name", "value"),
    [
        ("rod", "length", 1.0),
        ("rod", "length", 0.5),
        ("rod", "length", 0),
        ("rod", "length", 1e7),
        ("rod", "bending", 0.0),
        ("rod", "twisting", -0.1),
        ("rod", "twisting", 1e10),
        ("drop", "capillary_force", 0),
        ("drop", "wall_strength", 0),
        ("drop", "wall_softness", 0),
        ("drop", "wall_softness", 1.001),
        ("drop", "weight", -0.1),
        ("clamps", "end_rotation", 1e7),
        ("push", "start", 0),
        ("push", "stop", 0),
        ("push", "stop", []),
        ("push", "stop", ["0.2 pi", "nonsense"]),
        ("push", "at", [0.1, -0.1]),
        ("push", "at", ["0.1 pi", math.nan]),
        ("push", "max_step", 0),
        ("mesh", "edges", 11),
        ("mesh", "edges", 100_001),
        ("relax", "method", "newton"),
        ("relax", "method", 1),
        ("relax", "tolerance", 0.1),
        ("relax", "tolerance", 1e-16),
        ("noise", "seed", -1),
        ("noise", "seed", 2**63),
        ("noise", "amplitude", -1e-3),
        ("noise", "amplitude", 2),
        ("model", "dimension", 1),
        ("model", "dimension", 4),
        ("model", "drop", 0),
    ],
)
def test_values_out_of_range(table: str, name: str, value: Any) -> None:
    error = error_of(with_value(table, name, value))
    assert names_all(error, f"{table}.{name}"), str(error)


PLAIN = st.one_of(
    st.none(),
    st.booleans(),
    st.integers(),
    st.floats(),
    st.text(),
    st.from_regex(r"[+-]?[0-9]{0,3}\.?[0-9]{0,3} ?\*? ?(pi|π)?(/[0-9]{1,2})?", fullmatch=True),
    st.dates(),
    st.datetimes(),
)
ANYTHING = st.recursive(
    PLAIN, lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(), inner, max_size=3)
)


@given(st.sampled_from(ALL_KEYS), ANYTHING)
def test_any_value_gives_a_scene_or_a_scene_error(key: tuple[str, str], value: Any) -> None:
    table, name = key
    try:
        scene = build_scene(with_value(table, name, value), "some.toml")
    except SceneError as error:
        line = str(error)
        assert line.startswith("some.toml: ") and "\n" not in line
        assert error.key is not None
        if (table, name, value) != ("model", "drop", False):  # that one blames [drop]
            assert bare(error.key) in {f"{table}.{name}", "push.stop", "push.at"}
            assert error.allowed is not None
    else:
        assert parse_scene(dump_scene(scene)) == scene
        for number in [scene.rod.length, scene.clamps.end_rotation, *scene.push.stop]:
            assert math.isfinite(number)


@given(st.text(max_size=30), ANYTHING)
def test_unknown_tables(name: str, value: Any) -> None:
    if name in KEYS:
        return
    error = error_of({**BASE, name: value})
    assert error.key == name and error.problem.startswith("is unknown")
    assert error.allowed is not None


@given(st.sampled_from(sorted(KEYS)), st.text(max_size=30))
@example("rod", "lenght")
@example("push", "edges")
def test_unknown_keys(table: str, name: str) -> None:
    if name in KEYS[table]:
        return
    error = error_of(with_value(table, name, 1))
    assert bare(error.key) == f"{table}.{bare(name)}"
    assert error.problem.startswith("is unknown")
    assert error.allowed is not None and f"of [{table}]" in error.allowed


def test_unknown_keys_get_a_hint() -> None:
    assert "did you mean length?" in str(error_of(with_value("rod", "lenght", 10)))
    assert "belongs to [mesh]" in str(error_of(with_value("push", "edges", 100)))
    assert "did you mean drop?" in str(error_of({**BASE, "dorp": {}}))
    assert "[mesh] edges" in str(error_of({**BASE, "edges": 100}))


@pytest.mark.parametrize(("table", "name"), REQUIRED)
def test_missing_keys(table: str, name: str) -> None:
    data = {key: dict(values) for key, values in BASE.items()}
    del data[table][name]
    error = error_of(data)
    assert error.key == f"{table}.{name}" and error.problem == "is missing"
    assert error.allowed == KEYS[table][name].allowed


@given(st.text(max_size=200))
@example("[rod\n")
@example("a = " + "[" * 5000)
@example("[rod]\nlength = " + "9" * 5000)
@example("\x00")
def test_any_text_gives_a_scene_error(text: str) -> None:
    with pytest.raises(SceneError, match=r"^some\.toml: "):
        parse_scene(text, path="some.toml")


def test_files_that_cannot_be_read(tmp_path: Path) -> None:
    latin = tmp_path / "latin.toml"
    latin.write_bytes(b"# caf\xe9\n")
    for path in (tmp_path / "none.toml", tmp_path, latin):
        with pytest.raises(SceneError, match="cannot be read") as caught:
            load_scene(path)
        assert caught.value.file == str(path)


# -- angles and lengths


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("2.8 pi", 2.8 * math.pi),
        ("2.8pi", 2.8 * math.pi),
        ("2.8 * pi", 2.8 * math.pi),
        ("2.8 π", 2.8 * math.pi),
        ("pi", math.pi),
        ("-pi/2", -math.pi / 2),
        ("3 pi / 4", 3 * math.pi / 4),
        ("1e-3 pi", 1e-3 * math.pi),
        (" .5 ", 0.5),
        ("1/4", 0.25),
        (3, 3.0),
        (0.25, 0.25),
    ],
)
def test_quantities(text: object, value: float) -> None:
    assert read_quantity(text) == value


@pytest.mark.parametrize(
    "text",
    ["", " ", "* pi", "pi pi", "2 pi pi", "2,8 pi", "pi / 0", "1e999", "nan", "inf", "--1", "٣",
     "/2", "1 2", "0x10", "1_000", "9" * 101, True, None, math.nan, math.inf],
)  # fmt: skip
def test_what_is_no_quantity(text: object) -> None:
    with pytest.raises(ValueError, match=r".+"):
        read_quantity(text)


@given(st.floats(allow_nan=False, allow_infinity=False))
@example(2.8 * math.pi)
@example(-0.0)
@example(math.pi)
def test_written_quantities_read_back_exactly(value: float) -> None:
    text = write_quantity(value)
    assert read_quantity(json.loads(text)) == value


def test_multiples_of_pi_stay_legible() -> None:
    assert write_quantity(2.8 * math.pi) == '"2.8 pi"'
    assert write_quantity(math.pi) == '"pi"'
    assert write_quantity(0.0) == "0.0"
    assert write_quantity(1.25) == "1.25"


# -- round trip

POSITIVE = st.floats(1e-6, 1e6)


@st.composite
def scenes(draw: st.DrawFn) -> Scene:
    dry = draw(st.booleans())
    length = draw(st.floats(2.0, 100.0))  # half of it can be pushed in
    share = st.floats(1e-3, 0.25)
    start, low, high = (length * x for x in (draw(share), draw(share), 0.25 + draw(share)))
    stops = draw(st.sampled_from([[high], [high, low], [high, low, high]]))
    bottom = start if len(stops) == 1 else min(start, low)
    at = [bottom + x * (high - bottom) for x in draw(st.lists(st.floats(0.1, 0.9), unique=True))]
    dimension = draw(st.sampled_from([2, 3]))
    data: dict[str, dict[str, Any]] = {
        "rod": {"length": length, "bending": draw(POSITIVE), "twisting": draw(POSITIVE)},
        "clamps": {"end_rotation": 0 if dimension == 2 else draw(st.floats(-50, 50))},
        "push": {
            "start": start,
            "stop": stops[0] if len(stops) == 1 else stops,
            "at": sorted(set(at)),
            "max_step": draw(POSITIVE),
        },
        "mesh": {"edges": draw(st.integers(12, 100_000))},
        "relax": {
            "method": draw(st.sampled_from(["implicit", "elliptic", "fire", "kinetic"])),
            "tolerance": draw(st.floats(1e-15, 1e-2)),
        },
        "noise": {
            "seed": draw(st.integers(0, 2**63 - 1)),
            "amplitude": draw(st.floats(0, 1)),
        },
        "model": {"dimension": dimension, "drop": not dry},
    }
    if not dry:
        data["drop"] = {
            "capillary_force": draw(POSITIVE),
            "wall_strength": draw(POSITIVE),
            "wall_softness": draw(st.floats(1e-6, 1)),
        }
    return build_scene(data)


@given(scenes())
def test_round_trip(scene: Scene) -> None:
    text = dump_scene(scene)
    again = parse_scene(text)
    assert again == scene and hash(again) == hash(scene)
    assert dump_scene(again) == text == scene.text
    assert build_scene(plain_tables(scene)) == scene
    for table, name in ALL_KEYS:
        held = getattr(getattr(scene, table), name, None)
        if held is not None and table != "steps":
            assert f"\n{name} = " in text, f"{table}.{name} is written out"
    assert all(math.isfinite(group.value) for group in dimensionless_groups(scene))


def test_scenes_that_differ_are_not_equal() -> None:
    scene = build_scene(BASE)
    changes = {"rod.length": 11, "mesh.edges": 100, "noise.seed": 3, "push.at": [0.1]}
    for key, value in changes.items():
        assert scene.replace({key: value}) != scene, key
    assert build_scene(BASE, "elsewhere.toml") == scene, "the path is for messages only"
    assert scene != 3


def test_quantity_keys_take_strings_and_the_others_do_not() -> None:
    assert ("push", "stop") in QUANTITIES and ("rod", "bending") not in QUANTITIES
    scene = build_scene(with_value("clamps", "end_rotation", "-2 pi"))
    assert scene.clamps.end_rotation == -2 * math.pi
    assert names_all(error_of(with_value("rod", "bending", "1")), "rod.bending")


# -- keys that do not fit together


def test_a_rod_shorter_than_the_drop() -> None:
    error = error_of(with_value("rod", "length", 0.9))
    assert names_all(error, "rod.length") and "diameter" in str(error)


def test_a_push_past_what_the_rod_can_give() -> None:
    error = error_of(with_value("push", "stop", "3 pi"))
    assert names_all(error, "push.stop")
    assert '"3 pi"' in str(error) and "below 9.1" in str(error)
    error = error_of(with_value("push", "stop", ["0.4 pi", "0.2 pi", "3 pi"]))
    assert error.key == "push.stop[2]"
    assert names_all(error_of(with_value("push", "start", 9.5)), "push.start")


@pytest.mark.parametrize("value", ["0.5 pi", 1e-4])
def test_a_landing_outside(value: object) -> None:
    error = error_of(with_value("push", "at", ["0.1 pi", value]))
    assert names_all(error, "push.at") and "never reached" in str(error)


def test_landings_are_sorted_and_each_given_once() -> None:
    scene = build_scene(with_value("push", "at", ["0.3 pi", "0.1 pi"]))
    assert scene.push.at == (0.1 * math.pi, 0.3 * math.pi)
    error = error_of(with_value("push", "at", ["0.3 pi", "0.1 pi", "0.3 pi"]))
    assert names_all(error, "push.at") and "twice" in str(error)


def test_stops_must_turn() -> None:
    assert len(build_scene(with_value("push", "stop", [1.0, 0.5, 0.8])).push.stop) == 3
    error = error_of(with_value("push", "stop", [0.5, 1.0]))
    assert error.key == "push.stop[1]" and names_all(error, "push.stop")
    error = error_of(with_value("push", "stop", [1.0, 0.5, 0.5]))
    assert error.key == "push.stop[2]" and "does not move" in str(error)
    error = error_of(with_value("push", "stop", "0.001 pi"))
    assert names_all(error, "push.stop") and "does not move" in str(error)


def test_a_planar_rod_is_not_turned() -> None:
    data = with_value("model", "dimension", 2)
    assert build_scene(data).model.dimension == 2
    error = error_of({**data, "clamps": {"end_rotation": "2 pi"}})
    assert names_all(error, "clamps.end_rotation") and "model.dimension = 2" in str(error)


def test_no_drop() -> None:
    dry = {"rod": BASE["rod"], "push": BASE["push"], "model": {"drop": False}}
    scene = build_scene(dry)
    assert scene.drop is None and "[drop]" not in scene.text
    assert parse_scene(scene.text) == scene
    error = error_of({**dry, "drop": BASE["drop"]})
    assert error.key == "drop" and "model.drop = false" in str(error)
    assert error_of({**dry, "model": {"drop": True}}).key == "drop.capillary_force"
    short = {**dry, "rod": {**BASE["rod"], "length": 0.5}, "push": {"stop": 0.4}}
    assert build_scene(short).rod.length == 0.5, "shorter than a drop that is not there"
    assert error_of({**short, "push": {"stop": 0.5}}).key == "push.stop"


@pytest.mark.parametrize(
    ("changes", "key"),
    [
        ({"rod.bending": [1, 2]}, "clamps.directors"),
        ({"rod.natural_curvature": [1, 0]}, "clamps.directors"),
        ({"rod.bending": [1, 2], "clamps.directors": [0, 0], "rod.twisting": 0}, "rod.twisting"),
        (
            {"rod.bending": [1, 2], "clamps.directors": [0, 0], "relax.method": "fire"},
            "relax.method",
        ),
    ],
)
def test_a_section_lacks_what_a_push_needs(changes: dict[str, Any], key: str) -> None:
    scene = build_scene(BASE, "some.toml").replace(changes)
    with pytest.raises(SceneError) as caught:
        check_pushable(scene)
    assert caught.value.key == key and str(caught.value).count("\n") == 0


def test_a_step_that_turns_a_section_is_named() -> None:
    changes = {"rod.bending": [1, 2], "clamps.directors": [0, 0]}
    steps = [{"control": "end_rotation", "stop": 1.0, "max_step": 0.1}]
    scene = build_scene(BASE, "some.toml").replace(changes | {"steps": steps})
    with pytest.raises(SceneError) as caught:
        check_pushable(scene)
    assert caught.value.key == "steps[0].control"


def test_directors() -> None:
    scene = build_scene(with_value("clamps", "directors", [0, "pi/2"]))
    assert scene.clamps.directors == (0.0, math.pi / 2)
    assert scene.clamps.end_rotation == math.pi / 2, "their difference"
    assert "end_rotation" not in scene.text
    assert parse_scene(scene.text) == scene and build_scene(plain_tables(scene)) == scene
    for wrong in ([0], [0, 1, 2], 0, ["a", 0], [0, math.inf]):
        assert names_all(error_of(with_value("clamps", "directors", wrong)), "clamps.directors")
    turned = build_scene(BASE).replace({"clamps.directors": [0.5, 2]})
    assert turned.clamps.end_rotation == 1.5
    assert turned.replace({"clamps.directors": [0.5, 1]}).clamps.end_rotation == 0.5
    both = with_value("clamps", "directors", [0, 1])
    both["clamps"]["end_rotation"] = 2
    assert names_all(error_of(both), "clamps.end_rotation")


def test_natural_shape() -> None:
    scene = build_scene(with_value("rod", "natural_curvature", [0.5, -1]))
    assert scene.rod.natural_curvature == (0.5, -1.0) and scene.has_frames
    assert parse_scene(scene.text) == scene
    assert not build_scene(with_value("rod", "natural_twist", 0)).has_frames
    for name in ("natural_curvature", "natural_twist"):
        value = [1, 0] if name == "natural_curvature" else 1
        planar = with_value("rod", name, value) | {"model": {"dimension": 2}}
        assert names_all(error_of(planar), f"rod.{name}")


def test_two_bending_stiffnesses() -> None:
    scene = build_scene(with_value("rod", "bending", [1, 2]))
    assert (scene.rod.bending, scene.rod.bending_2) == (1.0, 2.0)
    assert "\nbending = [1.0, 2.0]\n" in scene.text and "bending_2" not in scene.text
    assert parse_scene(scene.text) == scene and build_scene(plain_tables(scene)) == scene
    assert scene.replace({"rod.bending": 3}).rod.bending_2 is None
    assert scene.replace({"rod.twisting": 3}).rod.bending_2 == 2.0
    same = build_scene(with_value("rod", "bending", [2, 2]))
    check_pushable(same)
    assert not same.has_frames, "it is a round rod, to the last bit"
    for wrong in ([1], [1, 2, 3], [1, -1], [1, "2"], [[1], 2], []):
        assert names_all(error_of(with_value("rod", "bending", wrong)), "rod.bending")
    assert error_of(with_value("rod", "bending_2", 2)).key == "rod.bending_2"


# -- replace


def test_replace() -> None:
    scene = build_scene(with_value("push", "at", ["0.1 pi", "0.3 pi"]), "some.toml")
    changed = scene.replace({"mesh.edges": 150, "push.stop": "0.2 pi"})
    assert changed.mesh.edges == 150 and changed.push.stop == (0.2 * math.pi,)
    assert changed.push.at == (0.1 * math.pi,), "landings beyond the new stop are dropped"
    assert changed.path == "some.toml" and changed.rod == scene.rod
    assert scene.mesh.edges == 200, "the scene itself stays"
    assert scene.replace({}) == scene


@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("mesh.edges", 3),
        ("push.stop", "3 pi"),
        ("push.stop", "nonsense"),
        ("push.at", ["0.9 pi"]),
        ("relax.method", "newton"),
        ("rod.length", math.nan),
    ],
)
def test_replaced_values_are_checked(key: str, value: Any) -> None:
    with pytest.raises(SceneError) as caught:
        build_scene(BASE, "some.toml").replace({key: value})
    assert names_all(caught.value, key)


def test_replaced_keys_are_checked() -> None:
    for key in ("rod.lenght", "nonsense.edges", "edges"):
        with pytest.raises(SceneError, match="is unknown"):
            build_scene(BASE).replace({key: 1})


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"push.max_step": 1e-300}, "lost in rounding"),
        ({"push.max_step": 1e-16}, "lost in rounding"),
        ({"drop.capillary_force": 1e-300}, "allowed: a number from 1e-12 to 1e9"),
    ],
)
def test_values_that_rounding_eats_are_refused(change: dict[str, float], words: str) -> None:
    with pytest.raises(SceneError, match=words):
        coil().replace(change)


def test_plans_that_nobody_can_mean() -> None:
    scene = coil().replace({"push.max_step": 1e-6})
    plan = planned(scene)
    assert plan.rows == 1 + int((scene.push.stop[0] - scene.push.start) / 1e-6)
    assert plan.size == plan.rows * (ROW_BYTES + 8 * (5 * 60 + 7))
    with pytest.raises(SceneError, match=r"plans at least 939337 rows, 2.59 GB.*--yes-really"):
        check_plan(scene)
    with pytest.raises(SceneError, match="yes_really"):
        derod.push(scene)
    check_plan(coil())


def test_replace_takes_numpys_values_and_its_own() -> None:
    scene = coil(stop='["0.3 pi", "0.1 pi"]', at='["0.2 pi"]')
    changed = scene.replace(
        {
            "mesh.edges": np.int32(64),
            "push.stop": np.array([0.5, 0.25]),
            "push.at": (np.float64(0.3),),
            "model.drop": np.bool_(True),
            "clamps": scene.clamps,
        }
    )
    assert changed.mesh.edges == 64 and type(changed.mesh.edges) is int
    assert changed.push.stop == (0.5, 0.25) and changed.push.at == (0.3,)
    assert scene.replace({"push.stop": scene.push.stop, "rod": scene.rod}) == scene
    for wrong in ({"push": 3}, {1: 2}, {"mesh.edges": np.array([3, 4])}, {"drop": object()}, []):
        with pytest.raises(SceneError) as caught:
            scene.replace(wrong)  # type: ignore[arg-type]
        assert "\n" not in str(caught.value)


def test_a_byte_order_mark_is_accepted(tmp_path: Path) -> None:
    path = tmp_path / "scene.toml"
    path.write_text("\ufeff" + coil().text, encoding="utf-8")
    assert derod.load_scene(path) == coil()


def test_nothing_that_steers_a_terminal_is_printed(tmp_path: Path) -> None:
    path = tmp_path / "\x1b]0;owned\x07.toml"
    for text in (
        '"\x7f\u202e' + "k" * 5000 + '" = 1',
        "[drop]\n'a\\u001b[31m' = 2\n",
        '[relax]\nmethod = "\\u001b[2J\\u202e"\n',
        "\x1b[2J",
    ):
        path.write_text(text, encoding="utf-8")
        with pytest.raises(SceneError) as caught:
            derod.load_scene(path)
        assert str(caught.value).isprintable() and len(str(caught.value)) <= 1000


def test_a_scene_that_is_no_scene_file(tmp_path: Path) -> None:
    path = tmp_path / "big.toml"
    path.write_text("# " + "x" * 300_000)
    with pytest.raises(SceneError, match="too long"):
        derod.load_scene(path)
    with pytest.raises(SceneError, match="no name of a file"):
        derod.load_scene(7)  # type: ignore[arg-type]
