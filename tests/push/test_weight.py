"""The weight of the drop: against branches that share no code, and the laws of statics."""

from __future__ import annotations

import numpy as np
import pytest

import derod
from derod.branches import Parameters, heavy_states
from derod.pushing.frames import Outcome
from derod.record import BaseRun
from derod.rod.state import in_space
from tests.scenes import coil


def heavy(weight: float, edges: int = 200, **changes: object) -> BaseRun:
    """A push of the paper's rod (figures) with a heavy drop."""
    scene = coil(edges=edges, stop='"0.6 pi"', at='["0.05 pi", "0.25 pi"]', wall=2e-2)
    names = {name.replace("_", ".", 1): value for name, value in changes.items()}
    return derod.push(scene.replace({"drop.weight": weight, **names}))


@pytest.mark.parametrize("weight", [0.5, 5.0])
def test_agrees_with_the_branches(weight: float) -> None:
    run = heavy(weight)
    assert run.outcome is Outcome.COMPLETED
    scene = run.scene
    deltas = [0.05 * np.pi, 0.25 * np.pi]
    states = heavy_states(Parameters.from_scene(scene), deltas, paths=("Ax", "3D"))
    for delta in deltas:
        (row,) = run.table[run.table["end_shortening"] == delta]
        stable = [state for state in states[delta] if state.stability.modes == 0]
        errors = [
            max(
                abs(row[mine] - state.values[theirs]) / max(1.0, abs(state.values[theirs]))
                for mine, theirs in (
                    ("end_tension", "end_tension"),
                    ("energy_hat", "energy_hat"),
                    ("drop_height", "drop_y"),
                    ("wetted_length", "wetted_length"),
                )
            )
            for state in stable
        ]
        assert min(errors) < 5e-6, (delta, errors)


@pytest.mark.parametrize(("weight", "rotation"), [(0.0, 0.7), (1.0, 0.0), (3.0, 1.2)])
def test_forces_and_moments_balance_in_every_row(weight: float, rotation: float) -> None:
    """n and m at both clamps hold the weight, whatever the mesh (equa:saut_global)."""
    run = heavy(weight, edges=40, clamps_end_rotation=rotation)
    for i, row in enumerate(run.table):

        def vector(name: str, row: np.void = row) -> np.ndarray:
            return np.array([row[f"{name}_{axis}"] for axis in "xyz"])

        load = np.array([0.0, -weight, 0.0])
        forces = vector("end_force") - vector("start_force") + load
        assert np.abs(forces).max() < 1e-8
        end, centre = run.positions(i)[-1], run.drop_center(i)
        moments = vector("end_moment") - vector("start_moment")
        moments += np.cross(end, vector("end_force")) + np.cross(centre, load)
        assert np.abs(moments).max() < 1e-7
        assert row["end_force_z"] == pytest.approx(row["end_tension"], abs=1e-12)
        assert row["start_force_z"] == pytest.approx(row["end_tension"], abs=1e-8)
        assert row["end_moment_z"] == row["start_moment_z"] == row["twisting_moment"]


def test_clamp_moments_are_curvatures_extrapolated_to_the_clamps() -> None:
    run = heavy(2.0, edges=200)
    s, x = run.arc_length(-1), in_space(run.positions(-1))
    tangents = np.diff(x, axis=0) / np.linalg.norm(np.diff(x, axis=0), axis=1)[:, None]
    middles = 0.5 * (s[1:] + s[:-1])
    slope = np.gradient(tangents, middles, axis=0, edge_order=2)
    curvature = np.cross(tangents, slope)[:6]
    guess = [np.polyval(np.polyfit(middles[:6], curvature[:, k], 3), 0.0) for k in range(2)]
    row = run.table[-1]
    assert row["start_moment_x"] == pytest.approx(guess[0], rel=0.02, abs=0.02)
    assert row["start_moment_y"] == pytest.approx(guess[1], rel=0.02, abs=0.02)


def test_no_weight_is_todays_rod_bit_for_bit() -> None:
    one, other = (
        heavy(0.0, edges=40),
        derod.push(heavy(0.0, edges=40).scene.replace({"drop.weight": 0})),
    )
    for name in ("end_tension", "energy_hat", "holonomy"):
        np.testing.assert_array_equal(one.table[name], other.table[name])
    assert not one.table["energy_weight"].any()


def test_a_heavy_rod_needs_no_kick_in_its_plane_and_hangs() -> None:
    run = heavy(
        2.0, edges=60, noise_amplitude=0.0, model_dimension=2, push_stop="0.2 pi", push_at=[]
    )
    assert run.outcome is Outcome.COMPLETED and not run.events
    assert (run.table["drop_height"] < 0).all()
    assert run.table["end_force_y"] == pytest.approx(1.0, abs=1e-8)  # W/2


def test_the_coil_rolls_to_a_tilted_state_and_back() -> None:
    """Past 1.0248 pi the hanging coil rolls; the flip symmetry is lost, and found again upside down."""
    places = ["1.02 pi", "1.035 pi", "1.09 pi"]
    run = heavy(
        2.0, edges=120, push_start="0.9 pi", push_stop="1.1 pi", push_at=places, push_locate=True
    )
    (event,) = [event for event in run.events if event.kind == "instability"]
    assert event.control_value / np.pi == pytest.approx(1.0248, abs=2e-4)

    def asymmetry(i: int) -> float:
        x = run.positions(i)
        flipped = x[::-1] * [-1, 1, -1]
        return float(np.abs(flipped - flipped[0] - x).max())

    rows = [
        int(np.flatnonzero(run.table["end_shortening"] == float(x.split()[0]) * np.pi)[0])
        for x in places
    ]
    upright, tilted, over = (asymmetry(i) for i in rows)
    assert upright < 1e-6 and tilted > 0.1 and over < 1e-5
    assert not run.table["unstable_modes"].any()


def test_an_upside_down_coil_is_wound_first_and_loaded_then() -> None:
    run = heavy(2.0, edges=60, push_start="1.2 pi", push_stop="1.25 pi", push_at=[], push_bend="up")
    assert run.outcome is Outcome.COMPLETED
    assert not run.table["unstable_modes"].any()
    assert run.table["end_force_y"] - run.table["start_force_y"] == pytest.approx(2.0, abs=1e-8)
