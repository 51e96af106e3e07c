"""Fits recover what made the data, say what the data do not determine, and refuse what is no data."""

from __future__ import annotations

import json
import tomllib
from pathlib import Path

import numpy as np
import pytest

import derod
from derod.cli import main
from derod.errors import SceneError
from derod.fits.data import Data, make_data, read_data
from derod.fits.model import Model, NoCurveError, differences
from derod.fits.solving import Fit, determined, fit
from derod.fits.writing import as_data, as_table, as_toml
from derod.scene import Scene
from tests.scenes import coil

FREE = ("drop.capillary_force", "rod.bending")
PLACES = np.linspace(0.03, 0.6, 14) * np.pi


def curve(scene: Scene, places: np.ndarray, keys: tuple[str, ...] = FREE) -> np.ndarray:
    """The scene's own forces."""
    data = make_data(places, np.zeros(len(places)))
    tables = [getattr(getattr(scene, key.partition(".")[0]), key.partition(".")[2]) for key in keys]
    return Model(scene, keys, data)(np.array(tables))


@pytest.fixture(scope="module")
def scene() -> Scene:
    return coil(edges=40, stop='"0.6 pi"')


@pytest.fixture(scope="module")
def exact(scene: Scene) -> np.ndarray:
    return curve(scene, PLACES)


@pytest.fixture(scope="module")
def noisy(scene: Scene, exact: np.ndarray) -> Fit:
    """One percent of noise, from a start that is 20 and 30 percent off."""
    noise = 0.01 * exact * np.random.default_rng(1).standard_normal(len(exact))
    data = make_data(PLACES, exact + noise, error=0.01 * exact)
    return fit(data, scene.replace({FREE[0]: 24.0, FREE[1]: 0.7}), FREE)


def test_noisy_data_give_back_their_scene_within_their_errors(noisy: Fit) -> None:
    assert noisy.converged and not noisy.warnings
    assert np.all(np.abs(noisy.values - [20.0, 1.0]) < 3.0 * noisy.errors)
    assert np.all(noisy.errors < [0.5, 0.1]) and noisy.freedom == len(PLACES) - 2
    assert np.count_nonzero(np.abs(noisy.residuals) < 3.0) == len(PLACES)
    assert noisy.chi_squared == pytest.approx(noisy.residuals @ noisy.residuals)


def test_the_errors_scale_with_those_of_the_data(scene: Scene, exact: np.ndarray) -> None:
    start = scene.replace({FREE[0]: 20.5})
    errors = [
        fit(make_data(PLACES, exact, error=share * exact), start, FREE).errors
        for share in (0.01, 0.02)
    ]
    assert errors[1] == pytest.approx(2.0 * errors[0], rel=1e-3)


def test_a_rod_in_other_units_of_stiffness_is_found(scene: Scene, exact: np.ndarray) -> None:
    """K0 is a unit: forces and all stiffnesses twice as large are the same rod."""
    start = scene.replace({FREE[0]: 42.0, FREE[1]: 1.9, "rod.twisting": 1.8})
    start = start.replace({"drop.wall_strength": 4e-4})
    found = fit(make_data(PLACES, 2.0 * exact), start, FREE)
    assert found.values == pytest.approx([40.0, 2.0], rel=1e-5)


def test_derivatives_agree_with_coarser_differences(scene: Scene) -> None:
    model = Model(scene, FREE, make_data(PLACES, np.zeros(len(PLACES))))
    values = np.array([20.0, 1.0])
    found = differences(model, values)
    for k, step in ((0, 2e-2), (1, 1e-3)):
        sides = [np.array(values), np.array(values)]
        sides[0][k] += step
        sides[1][k] -= step
        coarse = (model(sides[0]) - model(sides[1])) / (2.0 * step)
        assert found[:, k] == pytest.approx(coarse, rel=2e-3, abs=2e-3 * np.abs(coarse).max())


def test_another_jacobian_can_take_the_place_of_differences(
    scene: Scene, exact: np.ndarray
) -> None:
    asked = []

    def own(model: Model, values: np.ndarray) -> np.ndarray:
        asked.append(values)
        return differences(model, values)

    found = fit(make_data(PLACES, exact), scene.replace({FREE[0]: 21.0}), FREE[:1], jacobian=own)
    assert found.values == pytest.approx([20.0], rel=1e-6) and asked


def test_a_planar_curve_says_nothing_of_twisting(exact: np.ndarray) -> None:
    planar = coil(edges=40, stop='"0.2 pi"', dimension=2)
    places = np.linspace(0.03, 0.2, 8) * np.pi
    data = make_data(places, curve(planar, places))
    found = fit(data, planar, (FREE[0], "rod.twisting"))
    assert found.warnings == ("rod.twisting does not change the data: it is not determined",)
    assert np.isinf(found.errors[1]) and np.isfinite(found.errors[0])
    assert as_data(found)["errors"]["rod.twisting"] == "not determined"


def test_what_only_comes_as_a_product_is_told_to_be_undetermined() -> None:
    scene = derod.Scene("tpu-fibre", {"mesh.edges": 40, "push.stop": "0.3 pi"})
    scene = scene.replace({"push.max_step": "0.02 pi"})
    places = np.linspace(0.03, 0.3, 8) * np.pi * 200.2e-6
    keys = ("material.surface_tension", "material.contact_angle")
    made = make_data(places * 1e3, np.ones(8), units=("mm", "uN"))
    force = Model(scene, keys, made)(np.array([21.1e-3, np.radians(23.0)]))
    data = make_data(places, force, units=("m", "N"))
    assert data.si and 1e-8 < force.max() < 1e-4
    found = fit(data, scene, keys)
    assert any("can stand in for each other" in line for line in found.warnings)
    assert found.condition > 1e5 and np.isinf(found.errors).all()
    young = fit(
        data, scene.replace({"material.young_modulus": "15 MPa"}), ("material.young_modulus",)
    )
    assert young.values == pytest.approx([17e6], rel=1e-6)


def test_determined_agrees_with_the_normal_equations() -> None:
    chance = np.random.default_rng(5)
    jacobian = chance.standard_normal((20, 3)) * [1.0, 1e4, 1e-4]
    covariance, condition, warnings = determined(
        jacobian, ("a", "b", "c"), np.array([1.0, 1e-4, 1e4])
    )
    assert covariance == pytest.approx(np.linalg.inv(jacobian.T @ jacobian), rel=1e-9)
    assert 1.0 < condition < 10.0 and not warnings


def test_a_scene_that_cannot_give_the_data_is_told(scene: Scene, exact: np.ndarray) -> None:
    wrong = exact + 2.0 * np.sin(7.0 * PLACES)
    found = fit(make_data(PLACES, wrong, error=np.full(len(PLACES), 0.01)), scene, FREE[:1])
    assert any("does not give the data within their errors" in line for line in found.warnings)


def test_data_past_the_end_of_the_rod_are_named(scene: Scene) -> None:
    data = make_data(np.linspace(0.1, 9.05, 5), np.ones(5))
    with pytest.raises(NoCurveError, match=r"the push to 9.05 D ended early"):
        fit(data, scene, FREE[:1])
    with pytest.raises(SceneError, match="a push past what the rod can give"):
        fit(make_data(np.linspace(0.1, 20.0, 5), np.ones(5)), scene, FREE[:1])


def test_a_table_in_si_with_gaps_is_read(tmp_path: Path) -> None:
    file = tmp_path / "data.csv"
    file.write_text(
        "# a remark\nsample,Displacement (mm),force [uN],error [uN]\n"
        "1,0.2,8,0.1\n2,0,1,0.1\n3,0.1,7,0.1\n4,0.3,,0.1\n5,nan,3,0.1\n"
    )
    data = read_data(file)
    assert data.si and data.gaps == 3 and data.has_errors
    assert data.displacement == pytest.approx([1e-4, 2e-4])
    assert data.force == pytest.approx([7e-6, 8e-6]) and data.weight == pytest.approx([1e7, 1e7])


def test_weights_and_multiples_of_pi_are_read(tmp_path: Path) -> None:
    file = tmp_path / "data.csv"
    file.write_text("end_shortening,end_tension,weight\n0.1 pi,5,2\n0.2 pi,6,0\n")
    data: Data = read_data(file)
    assert not data.si and data.displacement == pytest.approx(np.pi * np.array([0.1, 0.2]))
    assert list(data.weight) == [2.0, 0.0] and not data.has_errors


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("", "is empty"),
        ("a,b\n1,2\n", "displacement is missing in the header"),
        ("displacement [mm],force [lb]\n1,2\n", "force = 'lb' has an unknown unit; allowed: K0/D"),
        ("displacement [mm],force\n1,2\n", "mixes reduced and SI"),
        ("displacement,force,error\n1,2,-1\n", "error = -1.0 is out of range"),
        ("displacement,force\n1,x\n", "line 2: force = 'x' is not understood"),
        ("displacement,force,force\n1,2,3\n", "force is there twice"),
        ("displacement,force,error,weight\n1,2,1,1\n", "are given both"),
    ],
)
def test_what_is_no_data_is_refused(tmp_path: Path, text: str, told: str) -> None:
    file = tmp_path / "data.csv"
    file.write_text(text)
    with pytest.raises(SceneError, match=told):
        read_data(file)


@pytest.mark.parametrize(
    ("free", "told"),
    [
        ((), "free is empty"),
        (("drop.pull",), "drop.pull is no key of a scene"),
        (("mesh.layer",), "mesh.layer cannot be fitted"),
        (("rod.length", "rod.length"), "rod.length is free twice"),
        (("material.diameter",), "material.diameter is not in the scene"),
    ],
)
def test_what_cannot_be_free_is_refused(scene: Scene, free: tuple[str, ...], told: str) -> None:
    with pytest.raises(SceneError, match=told):
        fit(make_data(PLACES, PLACES), scene, free)


def test_the_command_writes_what_it_found(
    tmp_path: Path, exact: np.ndarray, scene: Scene, capsys: pytest.CaptureFixture[str]
) -> None:
    data, start = tmp_path / "data.csv", tmp_path / "start.toml"
    rows = "\n".join(f"{x!r},{t!r}" for x, t in zip(PLACES.tolist(), exact.tolist(), strict=True))
    data.write_text(f"end_shortening,end_tension\n{rows}\n")
    start.write_text(scene.replace({FREE[0]: 21.0}).text)
    words = ["fit", str(data), str(start), "--free", FREE[0], "--plot", str(tmp_path / "fit.svg")]
    assert main([*words, "--scene-out", str(tmp_path / "fitted.toml")]) == 0
    found = tomllib.loads((tmp_path / "data-fit.toml").read_text())
    assert found["outcome"] == "converged"
    assert found["values"][FREE[0]] == pytest.approx(20.0, rel=1e-6)
    assert derod.load_scene(tmp_path / "fitted.toml").drop.capillary_force == pytest.approx(20.0)
    table = np.genfromtxt(tmp_path / "data-fit.csv", delimiter=",", skip_header=1)
    assert table[:, 2] == pytest.approx(exact, rel=1e-6) and table.shape == (len(PLACES), 4)
    assert b"<svg" in (tmp_path / "fit.svg").read_bytes()
    assert main(words) == 2 and "exists already" in capsys.readouterr().err
    assert main([*words, "--force", "-o", str(tmp_path / "x.json")]) == 0
    assert json.loads((tmp_path / "x.json").read_text())["values"] == found["values"]


def test_the_result_as_toml_can_be_read(noisy: Fit) -> None:
    found = tomllib.loads(as_toml(noisy))
    assert found["covariance"] == noisy.covariance.tolist()
    assert as_table(noisy).count("\n") == len(PLACES) + 1
