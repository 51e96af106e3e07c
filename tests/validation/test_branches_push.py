"""Relaxed states of the discrete rod against branches of the boundary-value problem.

They share no code. Both paper scenes and two further parameter sets, 24 end-shortenings each, on
two meshes: the errors are small, and fall nearly with the fourth order of the rod.
"""

from pathlib import Path

import numpy as np
import pytest

import derod
from derod.branches.files.compare import compare, worst
from derod.branches.files.record import open_branches
from derod.branches.files.writing import write_branches
from derod.branches.half_rod.parameters import Parameters
from derod.branches.paths.compute import compute_branches
from derod.scene import load_scene

pytestmark = pytest.mark.validation
RUNS = Path(__file__).parents[2] / "runs"
OTHERS = {
    "stiff-drop": {"drop.capillary_force": 26.0, "rod.length": 9.0, "rod.twisting": 0.75},
    "soft-wall": {"drop.wall_softness": 0.16, "drop.wall_strength": 3e-3, "rod.length": 11.0},
}
PLACES = tuple(float(d) for d in np.pi * np.linspace(0.1, 2.4, 24))
EDGES = (200, 400)


def scene_of(name):
    base = load_scene(
        RUNS / ("paper-figures.toml" if name == "paper-figures" else "paper-text.toml")
    )
    changes = dict(OTHERS.get(name, {}))
    changes["push.stop"] = 2.4 * np.pi
    changes["push.at"] = list(PLACES)
    return base.replace(changes)


@pytest.fixture(scope="module", params=["paper-text", "paper-figures", *OTHERS])
def held(request, tmp_path_factory):
    folder = tmp_path_factory.mktemp(request.param)
    scene = scene_of(request.param)
    own = Parameters.from_scene(scene)
    branches, complaints = compute_branches(own, ["Ax", "3D", "L2", "3D-L2"], count_modes=False)
    assert not complaints
    write_branches(folder / "branches.h5", own, branches)
    results = {}
    with open_branches(folder / "branches.h5") as file:
        for edges in EDGES:
            run = derod.push(scene.replace({"mesh.edges": edges}), folder / f"{edges}.h5")
            results[edges] = compare(run, file)
    return results


def landed(result):
    places = np.asarray(PLACES)
    near = np.abs(result["end_shortening"][:, None] - places).min(axis=1) < 1e-12
    return result[near]


def test_every_landing_lies_on_a_branch(held):
    for result in held.values():
        assert len(landed(result)) >= 20
        assert (landed(result)["branch"] != "").all()


def test_errors_are_small(held):
    errors = {name: value for name, (value, _) in worst(landed(held[400])).items()}
    assert errors["tension_error"] <= 5e-4
    assert errors["energy_error"] <= 5e-4
    assert errors["shape_error"] <= 1e-3


def test_errors_fall_with_a_high_order(held):
    """Root mean square over the landings (single rows may cross zero): 8.3 to 13 is measured.

    Second order would give 4; what keeps it from 16 is the wall's kink at the menisci.
    """
    coarse, fine = landed(held[200]), landed(held[400])
    for name in ("tension_error", "energy_error", "shape_error"):
        ratio = np.sqrt(np.mean(coarse[name] ** 2) / np.mean(fine[name] ** 2))
        assert ratio > 7, (name, ratio)


def test_command_line(tmp_path, capsys):
    """``derod compare``: 0 within the tolerance, 1 beyond it, 2 for the branches of another rod."""
    from derod.cli import main

    scene = scene_of("paper-text").replace({"push.stop": 0.3 * np.pi})
    derod.push(scene, tmp_path / "run.h5")
    for name, own in (
        ("same", Parameters.from_scene(scene)),
        ("other", Parameters(wall_strength=2e-2)),
    ):
        branches, _ = compute_branches(own, ["Ax", "3D"], count_modes=False)
        write_branches(tmp_path / f"{name}.h5", own, branches)
    words = ["compare", str(tmp_path / "run.h5"), str(tmp_path / "same.h5"), "--quiet"]
    assert main([*words, "--tolerance", "5e-4"]) == 0
    assert "rows lie on a branch" in capsys.readouterr().out
    assert main([*words, "--tolerance", "1e-9"]) == 1
    words[2] = str(tmp_path / "other.h5")
    assert main(words) == 2
    assert (
        "wall_strength = 0.0002 of the run is not that of the branches" in capsys.readouterr().err
    )
