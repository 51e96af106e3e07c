"""Scenes on which version 0.1 ended in a wrong state or gave up, with any step and seed: they end right.

The values were found by other meshes, other steps and the branches of the boundary-value problem.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any, NamedTuple

import pytest

import derod
from derod.scene import Scene
from tests.scenes import coil

RUNS = Path(__file__).parents[1] / "runs"


class Case(NamedTuple):
    """A scene and where it must end."""

    changes: dict[str, Any]
    energy_hat: float
    tension: float
    at: tuple[tuple[float, float, float], ...] = ()  # end-shortening, E_hat, t


CASES = {
    "a step longer than the last edge": Case(
        {
            "rod.length": 7.209,
            "rod.twisting": 1.1634,
            "drop.capillary_force": 9.9059,
            "drop.wall_strength": 6.5462e-4,
            "drop.wall_softness": 0.020628,
            "push.stop": 5.8985,
        },
        15.236722,
        9.534109,
    ),
    "long steps": Case(
        {
            "rod.length": 7.5894,
            "rod.twisting": 0.73713,
            "drop.capillary_force": 5.1064,
            "drop.wall_strength": 0.032728,
            "drop.wall_softness": 0.072044,
            "push.stop": 5.7625,
            "push.at": [0.6915, 1.4406, 2.8813, 4.3219, 5.1862],
            "mesh.edges": 400,
        },
        16.513113,
        4.411335,
    ),
    "landings": Case(
        {
            "rod.length": 6.055,
            "rod.twisting": 1.4196,
            "drop.capillary_force": 7.3316,
            "drop.wall_strength": 6.6408e-5,
            "drop.wall_softness": 0.219,
            "clamps.end_rotation": 1.673,
            "push.stop": 4.3191,
            "push.at": [0.5183, 1.0798, 2.1596, 3.2393, 3.8872],
            "mesh.edges": 400,
        },
        10.613814,
        5.044014,
        ((3.2393, 9.36072, 6.89180),),
    ),
}


def scene_of(case: Case, **more: Any) -> Scene:
    """The case's scene, with further changes."""
    return coil(edges=200).replace(
        {"push.start": 0.062832, "push.at": [], "noise.seed": 0, **case.changes, **more}
    )


def check(case: Case, step: float, seed: int) -> None:
    run = derod.push(scene_of(case, **{"push.max_step": step * math.pi, "noise.seed": seed}))
    assert run.ending is not None and run.ending.outcome == "completed", run.ending
    last = run.table[-1]
    assert last["energy_hat"] == pytest.approx(case.energy_hat, abs=2e-6)
    assert last["end_tension"] == pytest.approx(case.tension, abs=2e-6)
    for delta, energy, tension in case.at:
        (row,) = run.table[run.table["end_shortening"] == delta]
        assert row["energy_hat"] == pytest.approx(energy, abs=1e-5)
        assert row["end_tension"] == pytest.approx(tension, abs=1e-5)


@pytest.mark.parametrize("name", CASES)
def test_they_end_right(name: str) -> None:
    check(CASES[name], 0.1, 0)


@pytest.mark.validation
@pytest.mark.parametrize("seed", [1, 2, 77])
@pytest.mark.parametrize("step", [0.02, 0.05, 0.1])
@pytest.mark.parametrize("name", CASES)
def test_whatever_the_step_and_the_seed(name: str, step: float, seed: int) -> None:
    check(CASES[name], step, seed)


@pytest.mark.validation
@pytest.mark.parametrize("seed", [0, 5])
@pytest.mark.parametrize("step", [0.005, 0.02, 0.1])
def test_a_long_rod_with_one_turn(step: float, seed: int) -> None:
    scene = derod.load_scene(RUNS / "l20-r2pi.toml")
    run = derod.push(
        scene.replace({"mesh.edges": 300, "push.max_step": step * math.pi, "noise.seed": seed})
    )
    assert run.table["energy_hat"][-1] == pytest.approx(35.6763, abs=1e-4)
    assert run.table["end_tension"][-1] == pytest.approx(16.9786, abs=1e-4)


@pytest.mark.validation
@pytest.mark.parametrize("seed", [0, 5])
@pytest.mark.parametrize("step", [0.005, 0.02, 0.1])
def test_over_a_fold(step: float, seed: int) -> None:
    """The branch ends at 2.084: a snap is recorded there, and the push goes on."""
    run = derod.push(
        coil(edges=150).replace(
            {
                "rod.length": 13.237,
                "rod.twisting": 1.0402,
                "drop.capillary_force": 6.3294,
                "drop.wall_strength": 0.029397,
                "drop.wall_softness": 0.27514,
                "push.start": 0.062832,
                "push.stop": 10.837,
                "push.max_step": step * math.pi,
                "noise.seed": seed,
            }
        )
    )
    assert run.ending is not None and run.ending.outcome == "completed"
    (snap,) = [event for event in run.events if event.kind == "snap"]
    assert snap.end_shortening == pytest.approx(2.084, abs=0.02)
    assert snap.energy_after < snap.energy_before - 1
    assert run.table["energy_hat"][-1] == pytest.approx(22.434318, abs=1e-5)
