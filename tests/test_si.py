"""Experiments in SI: units, uncertainties, groups, and runs read back."""

from __future__ import annotations

import json
import math
import random
import tomllib
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

import derod
from derod import cli
from derod.branches.half_rod.parameters import Parameters
from derod.errors import SceneError
from derod.record import layout
from derod.scene import Scene, build_scene, dimensionless_groups, load_scene, parse_scene
from derod.scene.experiment import left_out, si_quantities
from derod.scene.material import DIMENSION_OF, MATERIAL_KEYS
from derod.scene.plain import plain_tables
from derod.scene.units import DIMENSIONS, Measured, plain_measured, propagate, read_measured

RUNS = Path(__file__).parent.parent / "runs"
FIBRE: dict[str, Any] = {
    "young_modulus": "17 MPa",
    "poisson_ratio": 0.5,
    "diameter": "5.6 um",
    "surface_tension": "21.1 mN/m",
    "contact_angle": "23 deg",
    "drop_diameter": "200.2 um",
    "length": "3.6 mm",
}
STRIP = {key: value for key, value in FIBRE.items() if key != "diameter"} | {
    "width": "160 um",
    "height": "40 um",
    "drop_diameter": "700 um",
}


def tables(
    changes: dict[str, Any] | None = None, base: dict[str, Any] = FIBRE, **others: dict[str, Any]
) -> dict[str, dict[str, Any]]:
    """A scene with [material]; changes to None take a key out."""
    material = {**base, **(changes or {})}
    data: dict[str, dict[str, Any]] = {
        "material": {key: value for key, value in material.items() if value is not None},
        "drop": {"wall_strength": 2e-4, "wall_softness": 0.1},
        "push": {"stop": "0.4 pi"},
    }
    for name, table in others.items():
        data[name] = {**data.get(name, {}), **table}
    return data


def error_of(data: dict[str, Any]) -> SceneError:
    with pytest.raises(SceneError) as caught:
        build_scene(data, "some.toml")
    return caught.value


def numbers(scene: Scene) -> dict[str, tuple[float, float]]:
    """Value and uncertainty of all that ``derod check`` shows, by symbol."""
    assert scene.material is not None
    groups = [
        *dimensionless_groups(scene),
        *si_quantities(scene, scene.material),
        *left_out(scene.material),
    ]
    return {group.symbol: (group.value, group.error) for group in groups}


def shown_by_check(path: Path, capsys: pytest.CaptureFixture[str]) -> dict[str, float]:
    assert cli.main(["check", str(path)]) == 0
    lines = capsys.readouterr().out.splitlines()
    return {line[2:20].strip(): float(line[20:].split()[0]) for line in lines if line[0] == " "}


# -- the groups of the two experiments, from the formulas of docs/si.md, by hand


def torsion_factor(aspect: float) -> float:
    """beta, from the slow series, 20 000 terms (the code sums a fast one)."""
    odd = range(39_999, 0, -2)
    total = sum(math.tanh(n * math.pi * aspect / 2) / n**5 for n in odd)
    return (1 - 192 / math.pi**5 / aspect * total) / 3


def test_groups_of_the_fibre(capsys: pytest.CaptureFixture[str]) -> None:
    E, d, D, L, gamma, theta = 17e6, 5.6e-6, 200.2e-6, 3.6e-3, 0.0211, 23 * math.pi / 180
    rho_drop, rho_rod, g, soft = 960, 1200, 9.80665, 0.1
    K = E * math.pi * d**4 / 64
    F = math.pi * d * gamma * math.cos(theta)
    M = rho_drop * math.pi * D**3 / 6
    expected = {
        "l": L / D,
        "k3/K": 2 / 3,
        "f_gamma D^2/K": F * D**2 / K,
        "L_EC/D": math.sqrt(K / F) / D,
        "K0": K,
        "K3": E / 3 * math.pi * d**4 / 32,
        "F_gamma": F,
        "K0/D^2": K / D**2,
        "K0/D": K / D,
        "L_EC": math.sqrt(K / F),
        "T_plateau": F - 2 * K / ((1 + soft) * D) ** 2,
        "t_plateau": F * D**2 / K - 2 / (1 + soft) ** 2,
        "d/D": d / D,
        "F_gamma/(gamma D)": F / (gamma * D),
        "L_c": math.sqrt(gamma / (rho_drop * g)),
        "Bo": rho_drop * g * (D / 2) ** 2 / gamma,
        "M g": M * g,
        "W": M * g * D**2 / K,
        "M g/F_gamma": M * g / F,
        "w_rod": rho_rod * g * math.pi * d**2 / 4 * D**3 / K,
    }
    shown = shown_by_check(RUNS / "tpu-fibre.toml", capsys)
    for symbol, value in expected.items():
        assert shown[symbol] == pytest.approx(value, rel=1e-7), symbol
    assert shown["f_gamma D^2/K"] == pytest.approx(16.68798, rel=1e-6), "as in docs/si.md"


def test_groups_of_the_strip(capsys: pytest.CaptureFixture[str]) -> None:
    E, w, h, D, L, gamma, theta = 2e5, 160e-6, 40e-6, 7e-4, 3e-3, 0.021, 23 * math.pi / 180
    K1, K2 = E * w * h**3 / 12, E * h * w**3 / 12
    beta = torsion_factor(4.0)
    K3 = E / 3 * beta * w * h**3
    F = 2 * (w + h) * gamma * math.cos(theta)
    expected = {
        "l": L / D,
        "k3/K": K3 / K1,
        "f_gamma D^2/K": F * D**2 / K1,
        "K0": K1,
        "K2": K2,
        "K3": K3,
        "J": beta * w * h**3,
        "F_gamma": F,
        "T_plateau": F - 2 * K1 / (1.1 * D) ** 2,
        "t_plateau": F * D**2 / K1 - 2 / 1.1**2,
        "w/D": w / D,
        "h/D": h / D,
        "K2/K0": K2 / K1,
        "J/(w h^3)": beta,
        "Bo": 960 * 9.80665 * (D / 2) ** 2 / gamma,
        "W": 960 * 9.80665 * math.pi * D**3 / 6 * D**2 / K1,
    }
    shown = shown_by_check(RUNS / "pvs-strip.toml", capsys)
    for symbol, value in expected.items():
        assert shown[symbol] == pytest.approx(value, rel=1e-7), symbol


@pytest.mark.parametrize(("aspect", "beta"), [(1, 0.1406), (2, 0.229), (4, 0.281), (10, 0.312)])
def test_the_torsion_constant_is_the_tabulated_one(aspect: float, beta: float) -> None:
    """Timoshenko and Goodier, section 109: beta of w/h = 1, 2, 4, 10, to three or four digits."""
    scene = build_scene(tables({"height": "10 um", "width": f"{10 * aspect} um"}, STRIP))
    value, _ = numbers(scene)["J/(w h^3)"]
    assert value == pytest.approx(beta, abs=6e-4)
    assert value == pytest.approx(torsion_factor(aspect), rel=1e-13)


def test_the_push_sees_a_plain_scene() -> None:
    scene = load_scene(RUNS / "tpu-fibre.toml")
    assert scene.rod.bending == 1.0 and scene.drop is not None
    plain = plain_tables(scene)
    del plain["material"]
    plain["rod"] = {"length": scene.rod.length, "bending": 1, "twisting": scene.rod.twisting}
    plain["drop"]["capillary_force"] = scene.drop.capillary_force
    other = build_scene(plain)
    assert other.tables() == {k: v for k, v in scene.tables().items() if k != "material"}


# -- uncertainties


def test_uncertainties_of_the_fibre_follow_from_the_powers() -> None:
    scene = build_scene(tables({"diameter": "5.6 +- 0.5 um"}))
    shown = numbers(scene)
    relative = 0.5 / 5.6
    for symbol, power in {
        "K0": 4,
        "F_gamma": 1,
        "f_gamma D^2/K": -3,
        "L_EC/D": 1.5,
        "d/D": 1,
    }.items():
        value, error = shown[symbol]
        assert error == pytest.approx(abs(power) * relative * value, rel=1e-12), symbol
    assert shown["t_plateau"][1] == pytest.approx(
        3 * relative * shown["f_gamma D^2/K"][0], rel=1e-12
    )
    assert shown["l"][1] == 0.0 and shown["k3/K"][1] == 0.0
    force, stiffness, D = shown["F_gamma"][0], shown["K0"][0], 200.2e-6
    slope = force - 4 * 2 * stiffness / (1.1 * D) ** 2  # d times dT/dd: F and K share d
    assert shown["T_plateau"][1] == pytest.approx(slope * relative, rel=1e-12)


def test_uncertainties_agree_with_sampling() -> None:
    """All inputs at once, against 20 000 draws; first order is good to the square of 1 %."""
    errors = {"young_modulus": 2e5, "diameter": 4e-8, "contact_angle": 0.004, "drop_diameter": 1e-6}
    values = {
        "young_modulus": 17e6,
        "diameter": 5.6e-6,
        "contact_angle": 0.4,
        "drop_diameter": 2e-4,
    }
    units = {"young_modulus": "Pa", "contact_angle": "rad"}
    given = {
        name: f"{value!r} +- {errors[name]!r} {units.get(name, 'm')}"
        for name, value in values.items()
    }
    value, error = numbers(build_scene(tables(given)))["f_gamma D^2/K"]
    rng = np.random.default_rng(5)
    E, d, theta, D = (rng.normal(values[k], errors[k], 20_000) for k in values)
    draws = math.pi * d * 0.0211 * np.cos(theta) * D**2 / (E * math.pi * d**4 / 64)
    assert value == pytest.approx(np.mean(draws), rel=2e-3)
    assert error == pytest.approx(np.std(draws), rel=0.02)


def test_the_complex_step_is_exact() -> None:
    x = {"a": Measured(3e-12, 1e-13), "b": Measured(2.0, 0.1), "c": Measured(0.0, 0.5)}
    got = propagate(lambda v: v["a"] ** 3 / v["b"] * (1 + v["c"]), x)
    partials = [3 * 3e-12**2 / 2 * 1e-13, 3e-12**3 / 4 * 0.1, 3e-12**3 / 2 * 0.5]
    assert got.value == pytest.approx(3e-12**3 / 2, rel=1e-14)
    assert got.error == pytest.approx(math.hypot(*partials), rel=1e-14)


# -- units


@pytest.mark.parametrize(
    ("text", "dimension", "value", "error"),
    [
        ("5.6 um", "length", 5.6e-6, 0.0),
        ("5.6um", "length", 5.6e-6, 0.0),
        ("5.6 µm", "length", 5.6e-6, 0.0),
        ("5.6 μm", "length", 5.6e-6, 0.0),
        ("5.6 +- 0.5 um", "length", 5.6e-6, 5e-7),
        ("5.6 ± .5 um", "length", 5.6e-6, 5e-7),
        ("5.6 +/- 0.5 um", "length", 5.6e-6, 5e-7),
        (5.6e-6, "length", 5.6e-6, 0.0),
        ("1e-3 cm", "length", 1e-5, 0.0),
        ("250 nm", "length", 2.5e-7, 0.0),
        ("17 MPa", "pressure", 17e6, 0.0),
        ("0.2 GPa", "pressure", 2e8, 0.0),
        ("21.1 mN/m", "tension", 0.0211, 0.0),
        ("21.1 dyn/cm", "tension", 0.0211, 0.0),
        ("23 deg", "angle", math.radians(23), 0.0),
        ("23°", "angle", math.radians(23), 0.0),
        ("0.96 g/cm^3", "density", 960.0, 0.0),
        ("960 kg/m³", "density", 960.0, 0.0),
        ("0.49 +- 0.01", "number", 0.49, 0.01),
        (1, "number", 1.0, 0.0),
    ],
)
def test_units(text: object, dimension: str, value: float, error: float) -> None:
    assert read_measured(text, dimension) == Measured(value, error)


@given(
    st.sampled_from(sorted(DIMENSIONS)),
    st.floats(1e-300, 1e100),
    st.just(0.0) | st.floats(0.0, 1e100),
)
@example("length", 5.6e-6, 5e-7)
@example("angle", math.radians(23), 0.0)
@example("angle", 0.1, 1e-17)
@example("angle", 9.999999999994359e99, 0.0)
def test_measured_quantities_read_back_exactly(dimension: str, value: float, error: float) -> None:
    measured = Measured(value, error)
    assert read_measured(plain_measured(measured, dimension), dimension) == measured


def test_quantities_stay_legible() -> None:
    for text, dimension in (
        ("5.6 +- 0.5 um", "length"),
        ("17 MPa", "pressure"),
        ("21.1 mN/m", "tension"),
        ("23 deg", "angle"),
    ):
        assert plain_measured(read_measured(text, dimension), dimension) == text


# -- what is wrong is answered in one line

BAD: dict[str, tuple[dict[str, Any], str, str]] = {
    "unknown unit": ({"diameter": "5.6 furlong"}, "diameter", "unknown unit"),
    "no unit": ({"diameter": "5.6"}, "diameter", "has no unit"),
    "another dimension": ({"diameter": "5.6 MPa"}, "diameter", "is a pressure"),
    "a unit on a number": ({"poisson_ratio": "0.5 m"}, "poisson_ratio", "is a length"),
    "negative modulus": ({"young_modulus": "-17 MPa"}, "young_modulus", "out of range"),
    "modulus zero": ({"young_modulus": 0}, "young_modulus", "out of range"),
    "uncertain to zero": ({"diameter": "5 +- 5 um"}, "diameter", "out of range"),
    "endless": ({"diameter": "1e999 m"}, "diameter", "too large"),
    "endless exponent": ({"diameter": "1e999999999 m"}, "diameter", "out of all bounds"),
    "thick end up": (
        {"diameter": None, "width": "40 um", "height": "160 um"}, "width", "less than the height"
    ),
    "thinner than zero": (
        {"diameter": None, "width": "160 um", "height": "-1 um"}, "height", "out of range"
    ),
    "two sections": ({"width": "10 um", "height": "5 um"}, "width", "beside a diameter"),
    "Poisson": ({"poisson_ratio": 0.6}, "poisson_ratio", "out of range"),
    "no wetting": ({"contact_angle": "90 deg"}, "contact_angle", "out of range"),
    "degrees as radians": ({"contact_angle": 23}, "contact_angle", "out of range"),
    "shorter than the drop": ({"length": "0.2 mm"}, "length", "makes l = L/D = 0.999"),
    "too soft": ({"young_modulus": "0.001 Pa", "diameter": "1 nm"}, "young_modulus", "f_gamma"),
    "no number": ({"diameter": True}, "diameter", "is not a number"),
    "a list": ({"diameter": ["1 um"]}, "diameter", "is not a number"),
    "nan": ({"diameter": math.nan}, "diameter", "finite"),
}  # fmt: skip


@pytest.mark.parametrize("case", BAD)
def test_bad_material(case: str) -> None:
    changes, key, problem = BAD[case]
    error = error_of(tables(changes))
    line = str(error)
    assert line.startswith(f"some.toml: material.{key} = ") and problem in line
    assert "; allowed: " in line and "\n" not in line


@pytest.mark.parametrize(
    ("changes", "others", "key"),
    [
        ({}, {"rod": {"length": 10}}, "rod.length"),
        ({}, {"rod": {"twisting": 0.9}}, "rod.twisting"),
        ({}, {"rod": {"bending": 1}}, "rod.bending"),
        ({}, {"drop": {"capillary_force": 20}}, "drop.capillary_force"),
    ],
)
def test_given_twice(changes: Any, others: Any, key: str) -> None:
    error = error_of(tables(changes, **others))
    assert error.key == key and "[material] gives it too" in str(error)


@pytest.mark.parametrize(
    "name",
    ["young_modulus", "surface_tension", "contact_angle", "drop_diameter", "diameter", "length",
     "poisson_ratio"],
)  # fmt: skip
def test_missing(name: str) -> None:
    error = error_of(tables({name: None}))
    assert error.key == f"material.{name}" and error.problem == "is missing" and error.allowed


def test_half_a_rectangle_is_missing() -> None:
    for name in ("width", "height"):
        assert error_of(tables({name: None}, STRIP)).key == f"material.{name}"


def test_other_refusals() -> None:
    error = error_of(tables({"yung_modulus": 1}))
    assert "did you mean young_modulus?" in str(error)
    data = tables(model={"drop": False})
    del data["drop"]
    assert error_of(data).key == "material" and "drop" in str(error_of(data))
    assert error_of({**tables(), "material": 3}).key == "material"


@given(
    st.sampled_from(sorted(MATERIAL_KEYS)),
    st.one_of(
        st.none(), st.booleans(), st.integers(), st.floats(), st.text(), st.lists(st.floats()),
        st.from_regex(r"-?[0-9]{0,3}\.?[0-9]{0,3} ?((\+-|±) ?[0-9.]{1,3})? ?(um|mm|MPa|mN/m|deg)?",
                      fullmatch=True),
    ),
)  # fmt: skip
def test_any_value_gives_a_scene_or_a_scene_error(name: str, value: Any) -> None:
    data = tables()
    data["material"][name] = value
    try:
        scene = build_scene(data, "some.toml")
    except SceneError as error:
        assert error.key is not None and "\n" not in str(error) and error.allowed is not None
    else:
        assert parse_scene(scene.text) == scene
        assert all(math.isfinite(x) for pair in numbers(scene).values() for x in pair)


def test_the_command_answers_2(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    text = (RUNS / "tpu-fibre.toml").read_text(encoding="utf-8")
    for old, new in (("17 MPa", "-17 MPa"), ("5.6 +- 0.5 um", "5.6 +- 0.5 parsec")):
        assert old in text
        file = tmp_path / "bad.toml"
        file.write_text(text.replace(old, new), encoding="utf-8")
        for command in (["check", str(file)], ["push", str(file), "-o", str(tmp_path / "x.h5")]):
            assert cli.main(command) == 2
            written = capsys.readouterr().err
            assert written.count("\n") == 1 and f"{file}: material." in written and new in written


# -- rectangles


def test_a_strip_is_pushed_if_it_knows_its_directors(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    strip = RUNS / "pvs-strip.toml"
    assert cli.main(["check", str(strip)]) == 0
    assert "can be pushed" in capsys.readouterr().out.splitlines()[0]
    lost = tmp_path / "lost.toml"
    lost.write_text(strip.read_text().replace("[clamps]\ndirectors = [0, 0]\n", ""))
    out = tmp_path / "strip.h5"
    assert cli.main(["push", str(lost), "-o", str(out)]) == 2
    line = capsys.readouterr().err
    assert line.count("\n") == 1 and "two bending stiffnesses" in line
    assert "clamps.directors" in line and not out.exists()
    run = derod.push(load_scene(strip).replace({"push.stop": "0.2 pi", "mesh.edges": 60}))
    assert run.outcome == "completed" and run.table["energy_twist"].max() == 0.0


def test_a_strip_has_branches() -> None:
    """K2/K1 = (w/h)^2, K3/K1 = 4 beta where it is incompressible."""
    scene = load_scene(RUNS / "pvs-strip.toml")
    found = Parameters.from_scene(scene, math.pi / 2)
    assert found.bending_2 == pytest.approx(16.0, rel=1e-14) and found.crossed
    assert found.twisting == pytest.approx(4 * torsion_factor(4.0), rel=1e-13)
    assert parse_scene(scene.text) == scene and build_scene(plain_tables(scene)) == scene
    assert "# bending = [1.0, 16.0]  # from [material]" in scene.text
    wider = scene.replace({"material.width": "200 um"})
    assert wider.rod.bending_2 == pytest.approx(25.0, rel=1e-14)
    assert {g.symbol: g.value for g in dimensionless_groups(scene)}["K2/K"] == pytest.approx(16.0)


def test_a_square_section_has_one_stiffness() -> None:
    scene = build_scene(tables({"width": "5 um", "height": "5 um", "diameter": None}))
    assert Parameters.from_scene(scene).twisting == pytest.approx(
        4 * torsion_factor(1.0), rel=1e-13
    )


# -- what is written, read, replaced


def scenes_to_round_trip() -> list[Scene]:
    rng = random.Random(3)
    scenes = [load_scene(RUNS / "tpu-fibre.toml"), load_scene(RUNS / "pvs-strip.toml")]
    for _ in range(200):
        changes = {
            "young_modulus": rng.uniform(1e5, 1e8),
            "diameter": f"{rng.uniform(1, 9)!r} +- {rng.uniform(0, 0.9)!r} um",
            "contact_angle": f"{rng.uniform(0, 89)!r} deg",
            "drop_diameter": f"{rng.uniform(100, 300)!r} um",
        }
        scenes.append(build_scene(tables(changes)))
    return scenes


def test_scenes_with_material_round_trip() -> None:
    for scene in scenes_to_round_trip():
        again = parse_scene(scene.text)
        assert again == scene and hash(again) == hash(scene) and again.text == scene.text
        assert build_scene(plain_tables(scene)) == scene
        data = tomllib.loads(scene.text)
        assert "capillary_force" not in data["drop"] and "bending" not in data["rod"]


def test_what_is_given_directly_is_kept() -> None:
    scene = build_scene(
        tables({"length": None, "poisson_ratio": None}, rod={"length": 12, "twisting": 0.9})
    )
    assert scene.rod.length == 12 and scene.rod.twisting == 0.9
    assert parse_scene(scene.text) == scene
    assert numbers(scene)["L"][0] == pytest.approx(12 * 200.2e-6, rel=1e-14)
    assert numbers(scene)["K3"][0] == pytest.approx(0.9 * numbers(scene)["K0"][0], rel=1e-14)


def test_replace() -> None:
    scene = build_scene(tables())
    stiffer = scene.replace({"material.young_modulus": "34 MPa", "mesh.edges": 100})
    assert scene.drop is not None and stiffer.drop is not None
    assert stiffer.drop.capillary_force == pytest.approx(scene.drop.capillary_force / 2, rel=1e-15)
    assert stiffer.mesh.edges == 100 and stiffer != scene
    with pytest.raises(SceneError, match="gives it too"):
        scene.replace({"rod.length": 11})


def test_a_scene_put_together_by_hand_must_agree_with_its_material() -> None:
    scene = build_scene(tables())
    other = msgspec.structs.replace(scene, rod=msgspec.structs.replace(scene.rod, length=9.0))
    with pytest.raises(SceneError, match=r"rod\.length = 9.0 is given, and \[material\]"):
        derod.push(other)


def test_lengths_of_the_push_with_units() -> None:
    push = {"stop": ["0.1001 mm", "0.1 pi"], "at": ["80.08 um"], "max_step": "20.02 um"}
    scene = build_scene(tables(push=push))
    assert scene.push.stop == pytest.approx((0.5, 0.1 * math.pi), rel=1e-15)
    assert scene.push.at == pytest.approx((0.4,)) and scene.push.max_step == pytest.approx(0.1)
    for value in ("20 parsec", "20 +- 1 um", "20 kPa"):
        error = error_of(tables(push={"max_step": value}))
        assert error.key == "push.max_step" and value in str(error)
    plain = {"rod": {"length": 10, "bending": 1, "twisting": 1}, "push": {"stop": "1 mm"}}
    plain["drop"] = {"capillary_force": 20, "wall_strength": 2e-4, "wall_softness": 0.1}
    assert error_of(plain).key == "push.stop", "without [material] nothing says what D is"


def test_every_key_has_a_dimension() -> None:
    assert set(DIMENSION_OF) == set(MATERIAL_KEYS)
    for name, key in MATERIAL_KEYS.items():
        assert json.dumps(key.allowed) and DIMENSION_OF[name] in DIMENSIONS


# -- runs in SI


@pytest.fixture(scope="module")
def run() -> Any:
    scene = build_scene(tables(push={"stop": "0.02 pi"}, mesh={"edges": 60}))
    return derod.push(scene)


def test_runs_read_back_in_si(run: Any) -> None:
    D, K = 200.2e-6, 17e6 * math.pi * 5.6e-6**4 / 64
    scale = {"D": D, "K0 D-2": K / D**2, "K0 D-1": K / D}
    unit = {"D": "m", "K0 D-2": "N", "K0 D-1": "J"}
    si = run.si
    for name in run.table.dtype.names:
        stored = layout.ROW_UNITS.get(name)
        expected = run.table[name] * scale.get(stored, 1.0) if stored else run.table[name]
        assert si.table[name] == pytest.approx(expected, rel=1e-12, abs=0), name
        assert np.array_equal(si[name], si.table[name])
        assert si.units[name] == unit.get(stored, stored or "")
    assert si.positions(-1) == pytest.approx(run.positions(-1) * D, rel=1e-12)
    assert si.arc_length(-1)[-1] == pytest.approx(3.6e-3, rel=1e-12)
    assert si.edge_tension(-1) == pytest.approx(run.edge_tension(-1) * K / D**2, rel=1e-12)
    assert si.drop_center(-1) == pytest.approx(run.drop_center(-1) * D, rel=1e-12)
    assert si.extrapolated is None


def test_work_of_the_end_is_energy_in_si(run: Any) -> None:
    """dE_tot = -T dDelta (docs: t = -dE_tot/ddelta): force, length and energy scale together."""
    table = run.si.table[1:]
    work = -np.trapezoid(table["end_tension"], table["end_shortening"])
    change = table["energy_total"][-1] - table["energy_total"][0]
    assert change < 0 and work == pytest.approx(change, rel=2e-2)


def test_a_run_without_material_has_no_si() -> None:
    plain = load_scene(RUNS / "quick.toml").replace({"push.stop": 0.01, "mesh.edges": 40})
    with pytest.raises(SceneError, match="material is missing"):
        _ = derod.push(plain).si


def test_info_si(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "run.h5"
    scene = build_scene(tables(push={"stop": "0.01 pi"}, mesh={"edges": 60}))
    with derod.push(scene, path) as stored:
        assert stored.scene == scene and stored.scene.material == scene.material
        force = stored.si["end_tension"][-1]
    assert cli.main(["info", "--si", str(path)]) == 0
    lines = capsys.readouterr().out.splitlines()
    head = next(i for i, line in enumerate(lines) if "end_tension uN" in line)
    last = lines[lines.index("ranges", head) - 1].split()
    assert float(last[4]) == pytest.approx(force * 1e6, rel=1e-5)
    assert lines[head - 1].startswith("in SI: D = 0.0002002 m, K0 = 8.20674e-16")


def test_runs_with_material_resume_and_extrapolate(tmp_path: Path) -> None:
    path = tmp_path / "run.h5"
    scene = build_scene(tables(push={"stop": "0.01 pi"}, mesh={"edges": 60}))
    derod.push(scene, path).close()
    further = scene.replace({"push.stop": "0.02 pi"})
    with pytest.raises(SceneError, match=r"material differs"):
        derod.push(further.replace({"material.drop_density": 960}), resume=path)
    with derod.push(further, resume=path) as run:
        assert run.scene == further and run.ending is not None
        assert run.si["end_shortening"][-1] == pytest.approx(0.02 * math.pi * 200.2e-6, rel=1e-12)
    better = derod.push(scene, extrapolate=True)
    rows, stored = better.si.extrapolated, better.extrapolated
    assert rows is not None and stored is not None
    force = better.si.scales.force
    for name in ("end_tension", "end_tension_error"):
        assert np.isfinite(stored[name]).any()
        assert rows[name] == pytest.approx(stored[name] * force, rel=1e-12, abs=0, nan_ok=True)
