"""Scene files: what is read, what is refused and how, and the way back to text."""

from __future__ import annotations

import math
import tomllib
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from derod.errors import SceneError
from derod.scene import Scene, build_scene, dimensionless_groups, load_scene, parse_scene
from derod.scene.quantities import read_quantity, write_quantity
from derod.scene.reading import plain_tables
from derod.scene.rules import KEYS
from tests.synthetic import small_scene

RUNS = Path(__file__).parents[1] / "runs"
SCENES = ("paper-text", "paper-figures", "quick")
PLAIN = plain_tables(small_scene())


def changed(key: str, value: Any) -> dict[str, dict[str, Any]]:
    """The small scene as plain tables, with one key changed."""
    table, name = key.split(".")
    return {**PLAIN, table: {**PLAIN[table], name: value}}


def refusal(data: dict[str, Any]) -> SceneError:
    with pytest.raises(SceneError) as caught:
        build_scene(data, "some.toml")
    return caught.value


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("2.8 pi", 2.8 * math.pi),
        ("-0.5 pi", -0.5 * math.pi),
        ("pi", math.pi),
        ("+pi", math.pi),
        ("π", math.pi),
        ("2*pi", 2 * math.pi),
        ("pi/2", math.pi / 2),
        (" 3 pi / 4 ", 3 * math.pi / 4),
        ("1e-3", 1e-3),
        (".5", 0.5),
        ("7", 7.0),
        (3, 3.0),
    ],
)
def test_quantities(text: str | float, value: float) -> None:
    assert read_quantity(text) == value


@pytest.mark.parametrize(
    "text",
    [
        "",
        " ",
        "two pi",
        "pi pi",
        "*pi",
        "1 2",
        "/2",
        "pi/0",
        "1e999",
        "nan",
        "inf",
        "0x10",
        "١",
        "1_0",
        "__import__('os')",
        "1" * 200,
        "2 pi rad",
        True,
        None,
        [1],
        float("nan"),
        10**400,
    ],
)
def test_what_is_no_quantity(text: Any) -> None:
    with pytest.raises(ValueError, match=r".+"):
        read_quantity(text)


@given(st.floats(allow_nan=False, allow_infinity=False))
def test_written_quantities_come_back_exactly(value: float) -> None:
    assert read_quantity(tomllib.loads(f"x = {write_quantity(value)}")["x"]) == value


@given(st.integers(-3000, 3000).filter(bool))
def test_short_multiples_of_pi_are_written_as_such(thousandths: int) -> None:
    assert write_quantity(thousandths / 1000 * math.pi).endswith('pi"')


@pytest.mark.parametrize("name", SCENES)
def test_shipped_scenes(name: str) -> None:
    scene = load_scene(RUNS / f"{name}.toml")
    assert scene.rod.length == 10.0
    assert scene.push.start == 0.001 * math.pi
    again = parse_scene(scene.text)
    assert again == scene
    assert again.text == scene.text


def test_the_two_scenes_of_the_paper_differ_in_the_wall_only() -> None:
    text, figures = (load_scene(RUNS / f"{name}.toml") for name in SCENES[:2])
    assert figures.drop is not None
    assert figures.drop.wall_strength == 2e-2
    assert text == figures.replace({"drop.wall_strength": 2e-4})
    assert text.push.stop == (2.8 * math.pi,)
    assert len(text.push.at) == 8


@pytest.mark.parametrize(
    ("key", "value", "allowed"),
    [
        ("rod.length", 0.5, "above 1"),
        ("rod.length", -10, "above 1"),
        ("rod.length", 1.0, "above 1"),
        ("rod.bending", 0, "above 0"),
        ("rod.bending", [1, 2], "a number"),
        ("rod.bending", True, "a number"),
        ("rod.twisting", "0.9", "a number"),
        ("drop.capillary_force", math.nan, "above 0"),
        ("drop.capillary_force", math.inf, "above 0"),
        ("drop.wall_softness", 0, "above 0"),
        ("drop.weight", 1, "0"),
        ("push.start", 0, "above 0"),
        ("push.stop", "3 pi", "below 9.1"),
        ("push.stop", [], "turning points"),
        ("push.stop", "0.01 pi", "another"),
        ("push.at", 0.5, "a list"),
        ("push.max_step", -0.1, "above 0"),
        ("mesh.edges", 4, "from 12"),
        ("mesh.edges", 100.0, "integer"),
        ("relax.method", "newton", "implicit"),
        ("relax.tolerance", 1.0, "1e-2"),
        ("noise.seed", -1, "from 0"),
        ("noise.amplitude", 2, "to 1"),
        ("model.dimension", 4, "2 or 3"),
        ("clamps.end_rotation", "half", "angle"),
    ],
)
def test_a_refused_value_is_named_with_what_is_allowed(key: str, value: Any, allowed: str) -> None:
    error = refusal(changed(key, value))
    assert error.file == "some.toml"
    assert error.key == key
    assert error.allowed is not None
    assert allowed in error.allowed
    line = str(error)
    assert line.startswith(f"some.toml: {key} = ")
    assert "\n" not in line
    assert error.allowed in line


@pytest.mark.parametrize("key", ["rod.bending", "drop.weight"])
def test_what_is_not_there_yet_says_so(key: str) -> None:
    value = [1, 2] if key == "rod.bending" else 0.5
    assert "not yet" in str(refusal(changed(key, value)))


def test_turning_points_must_turn() -> None:
    error = refusal({**PLAIN, "push": {"start": 0.1, "stop": [1.0, 0.5, 0.4]}})
    assert error.key == "push.stop[2]"
    assert build_scene({**PLAIN, "push": {"start": 0.1, "stop": [1.0, 0.5, 0.6]}}).push.stop == (
        1.0,
        0.5,
        0.6,
    )


def test_landings_must_be_reached_and_are_sorted() -> None:
    assert refusal(changed("push.at", ["0.1 pi", "0.5 pi"])).key == "push.at[1]"
    assert "twice" in str(refusal(changed("push.at", [0.2, 0.2])))
    assert build_scene(changed("push.at", [0.5, 0.2])).push.at == (0.2, 0.5)


def test_a_planar_rod_is_not_twisted() -> None:
    planar = changed("model.dimension", 2)
    assert build_scene(planar).model.dimension == 2
    assert refusal({**planar, "clamps": {"end_rotation": 1}}).key == "clamps.end_rotation"


@pytest.mark.parametrize(
    ("data", "hint"),
    [
        (changed("push.stopp", 1), "did you mean stop?"),
        (changed("rod.edges", 1), "it belongs to [mesh]"),
        ({**PLAIN, "dropp": {}}, "did you mean drop?"),
        ({**PLAIN, "length": 3}, "[rod] length"),
        ({**PLAIN, "mesh": 3}, "is not a table"),
        ({**PLAIN, "push": {}}, "push.stop is missing"),
        ({key: value for key, value in PLAIN.items() if key != "rod"}, "rod.length is missing"),
    ],
)
def test_what_is_unknown_or_missing(data: dict[str, Any], hint: str) -> None:
    assert hint in str(refusal(data))


@pytest.mark.parametrize(
    "content",
    [
        b"[rod",
        b"\xff\xfe",
        b"x = 1979-13-01",
        b"a = " + b"[" * 5000,
        b"a = " + b"9" * 5000,
        b"[rod]\0",
    ],
)
def test_files_that_are_no_toml(tmp_path: Path, content: bytes) -> None:
    path = tmp_path / "bad.toml"
    path.write_bytes(content)
    with pytest.raises(SceneError, match=r"bad\.toml"):
        load_scene(path)


@pytest.mark.parametrize("name", ["missing.toml", ".", "nul\0l"])
def test_files_that_cannot_be_read(tmp_path: Path, name: str) -> None:
    with pytest.raises(SceneError, match="cannot be read"):
        load_scene(f"{tmp_path}/{name}")


def test_a_replaced_stop_drops_the_landings_beyond_it() -> None:
    shorter = small_scene().replace({"push.stop": "0.2 pi"})
    assert shorter.push.stop == (0.2 * math.pi,)
    assert shorter.push.at == (0.1 * math.pi,)
    with pytest.raises(SceneError, match=r"mesh\.edges"):
        small_scene().replace({"mesh.edges": 2})


def test_groups() -> None:
    groups = {group.symbol: group.value for group in dimensionless_groups(small_scene())}
    assert groups["l"] == 10.0
    assert groups["f_gamma D^2/K"] == 20.0
    assert groups["L_EC/D"] == pytest.approx(20**-0.5)
    assert groups["delta_max/pi"] == pytest.approx(0.4)


values = st.recursive(
    st.none()
    | st.booleans()
    | st.integers()
    | st.floats()
    | st.text(max_size=8)
    | st.sampled_from(["pi", "2 pi", "-pi", "1/0", "fire", 10**400, "1e400"]),
    lambda inner: (
        st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=4), inner, max_size=2)
    ),
    max_leaves=5,
)
paths = st.sampled_from([f"{table}.{name}" for table, keys in KEYS.items() for name in keys])


def accepted(data: dict[str, Any]) -> Scene | None:
    """The scene, or None if it is refused; any other exception is a failure."""
    try:
        return build_scene(data, "some.toml")
    except SceneError as error:
        assert str(error).startswith("some.toml: ")
        assert "\n" not in str(error)
        return None


@settings(max_examples=400, deadline=None)
@given(paths, values)
def test_any_value_is_read_or_refused_and_what_is_read_comes_back(key: str, value: Any) -> None:
    scene = accepted(changed(key, value))
    if scene is not None:
        assert parse_scene(scene.text) == scene


@settings(max_examples=200, deadline=None)
@given(st.dictionaries(st.sampled_from([*KEYS, "other"]), values, max_size=4))
def test_any_tables_are_read_or_refused(data: dict[str, Any]) -> None:
    accepted(data)


@settings(max_examples=200, deadline=None)
@given(st.text(max_size=40))
def test_any_text_is_read_or_refused(text: str) -> None:
    with pytest.raises(SceneError):  # no text of this length is a whole scene
        parse_scene(text, "some.toml")


@settings(max_examples=100, deadline=None)
@given(
    st.floats(1.5, 1000.0),
    st.lists(st.floats(0.01, 0.5), min_size=1, max_size=3, unique=True),
    st.integers(12, 100_000),
    st.floats(1e-9, 1e6),
)
def test_what_is_written_comes_back(
    length: float, stops: list[float], edges: int, wall: float
) -> None:
    data = changed("rod.length", length)
    data["push"] = {"start": 0.001, "stop": stops}
    data["mesh"] = {"edges": edges}
    data["drop"] = {**data["drop"], "wall_strength": wall}
    scene = accepted(data)
    if scene is not None:
        assert parse_scene(scene.text) == scene
        assert parse_scene(scene.text).text == scene.text
