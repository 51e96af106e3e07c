"""Richardson extrapolation: what it gives, what it refuses, and how it is kept."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import derod
from derod.errors import SceneError
from derod.record.extrapolate import coarser, extrapolate
from tests.scenes import coil

CHANGES = {"mesh.edges": 200, "push.stop": "1 pi", "push.at": [], "push.max_step": "0.04 pi"}


@pytest.fixture(scope="module")
def fine() -> derod.record.BaseRun:
    return derod.push(coil().replace(CHANGES), extrapolate=True)


@pytest.fixture(scope="module")
def exact(fine) -> np.ndarray:
    """The same end-shortenings on a mesh 4 times as fine."""
    places = [float(x) for x in fine.table["end_shortening"][1:-1]]
    scene = coil().replace({**CHANGES, "mesh.edges": 800, "push.at": places})
    table = derod.push(scene).table
    _, first, second = np.intersect1d(
        fine.table["end_shortening"], table["end_shortening"], return_indices=True
    )
    assert (first == np.arange(len(fine))).all()
    return table[second]


def test_every_row_has_a_partner(fine) -> None:
    assert np.isfinite(fine.extrapolated["end_tension"]).all()
    assert (fine.extrapolated["end_shortening"] == fine.table["end_shortening"]).all()


@pytest.mark.parametrize("name", ["energy_hat", "wetted_length"])
def test_the_estimate_is_the_error_and_the_extrapolated_value_is_better(fine, exact, name) -> None:
    true = np.abs(fine.table[name] - exact[name])
    estimated = fine.extrapolated[f"{name}_error"]
    left = np.abs(fine.extrapolated[name] - exact[name])
    assert 0.4 < np.sqrt(np.mean(estimated**2) / np.mean(true**2)) < 2.5
    assert np.sqrt(np.mean(left**2)) < 0.7 * np.sqrt(np.mean(true**2))


def test_the_order_is_four(fine, exact) -> None:
    coarse = derod.push(coarser(fine)).table
    _, first, second = np.intersect1d(
        exact["end_shortening"], coarse["end_shortening"], return_indices=True
    )
    assert len(first) == len(exact)
    error = [
        np.sqrt(np.mean((table["energy_hat"] - exact["energy_hat"][first]) ** 2))
        for table in (coarse[second], fine.table[first])
    ]
    assert 3.3 < np.log2(error[0] / error[1]) < 5.0


def test_rows_in_other_states_are_not_compared(fine) -> None:
    """A coarse push that keeps to the plane, for want of noise, is another state from 0.24 pi on."""
    scene = coarser(fine).replace({"noise.amplitude": 0})
    rows = extrapolate(derod.push(scene), fine)
    inside = fine.table["end_shortening"] < 0.23 * np.pi
    assert np.isfinite(rows["end_tension"][inside]).all()
    assert np.isnan(rows["end_tension"][~inside][-1])


@pytest.mark.parametrize(
    ("changes", "key"),
    [
        ({"rod.twisting": 0.8}, "rod"),
        ({"drop.wall_strength": 1e-3}, "drop"),
        ({"mesh.layer": 0.3}, "mesh.layer"),
        ({"mesh.edges": 140}, "mesh.edges"),
    ],
)
def test_runs_of_other_rods_are_refused(fine, changes, key) -> None:
    short = {"push.stop": "0.01 pi", "push.at": []}
    coarse = derod.push(coarser(fine).replace({**short, **changes}))
    with pytest.raises(SceneError) as caught:
        extrapolate(coarse, fine)
    assert caught.value.key == key


def test_the_command_keeps_the_rows_with_the_run(tmp_path: Path, capsys) -> None:
    from derod.cli import main

    scene, path = tmp_path / "scene.toml", tmp_path / "run.h5"
    scene.write_text(coil().replace({**CHANGES, "push.stop": "0.1 pi"}).text)
    assert main(["push", str(scene), "-o", str(path), "--extrapolate", "--quiet"]) == 0
    with derod.open_run(path) as run:
        assert len(run.extrapolated) == len(run)
        assert np.isfinite(run.extrapolated["energy_hat"]).all()
        assert run.outcome == "completed"
    assert main(["info", str(path)]) == 0
    assert "estimated errors" in capsys.readouterr().out
    assert [entry.name for entry in sorted(tmp_path.iterdir())] == ["run.h5", "scene.toml"]
    # going on makes the rows out of date: they are gone until the run is extrapolated again
    assert main(["push", "--resume", str(path), "--stop", "0.12 pi", "--quiet"]) == 0
    with derod.open_run(path) as run:
        assert run.extrapolated is None


def test_too_few_edges_to_halve_are_refused_before_any_push(tmp_path: Path) -> None:
    path = tmp_path / "run.h5"
    with pytest.raises(SceneError, match=r"mesh\.edges"):
        derod.push(coil().replace({**CHANGES, "mesh.edges": 20}), path, extrapolate=True)
    assert not path.exists()
