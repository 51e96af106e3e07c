"""Whole pushes keep the symmetries of the rod: its mirror image, and its other end first."""

from __future__ import annotations

from typing import Any
from unittest.mock import patch

import numpy as np
import pytest

import derod
from derod.equilibrium.measured import measure
from derod.equilibrium.system import System
from derod.pushing import driver, first
from derod.pushing.columns import Settled
from derod.pushing.controls import CONTROLS
from derod.pushing.encode import decode, encode
from derod.record import BaseRun
from derod.rod.state import State
from tests.scenes import coil

NUMBERS = ("end_shortening", "end_tension", "energy_hat", "energy_bend", "wetted_length")


def mirrored(state: State) -> State:
    """The image at the plane x = 0; the holonomy changes its sign."""
    image = state.copy()
    image.q[:, 0] *= -1
    image.b[2] *= -1
    image.holonomy *= -1
    return image


def from_the_other_end(state: State, length: float) -> State:
    """The rod turned by pi about a line across its axis: what was the end is the start."""
    image = state.copy()
    d = state.dimension
    end = state.q[-1, d - 1]
    image.q[:, :d] = state.q[::-1, :d]
    image.q[:, d - 1] = end - image.q[:, d - 1]
    image.q[1:, d] = state.q[1:, d][::-1]
    if d == 3:
        image.q[:, 0] *= -1
    image.b[0], image.b[1] = length - state.b[1], length - state.b[0]
    if d == 3:
        image.b[2] *= -1
    image.b[1 + d] = end - state.b[1 + d]
    image.b[2 + d], image.b[3 + d] = state.b[3 + d], state.b[2 + d]
    image.b[4 + d] *= -1
    return image


def push_from(scene: derod.Scene, change) -> BaseRun:
    """Push a scene from the image of its first guess, and kick with the image of its noise."""
    real = first.bent_guess

    def guess(system: System, physics: Any, delta: float, side: float) -> State:
        state = real(system, physics, delta, side)
        if state.dimension == 3:  # out of its plane, so that there is something to mirror
            place = np.linspace(0, np.pi, system.edges + 1)[1:-1]
            state.q[1:-1, 0] += 2e-3 * np.sin(place) + 1e-3 * np.sin(2 * place)
        return change(state)

    with patch.object(first, "bent_guess", guess):
        return derod.push(scene)


@pytest.mark.parametrize("rotation", [0.0, 1.7])
def test_the_mirror_image(rotation: float) -> None:
    scene = coil(edges=60, stop='"0.4 pi"', rotation=rotation)
    run = push_from(scene, lambda state: state)
    image = push_from(scene.replace({"clamps.end_rotation": -rotation}), mirrored)
    assert len(run) == len(image)
    for name in NUMBERS:
        np.testing.assert_allclose(image.table[name], run.table[name], rtol=1e-8, atol=1e-9)
    np.testing.assert_allclose(
        np.abs(image.table["holonomy"]), np.abs(run.table["holonomy"]), atol=1e-6
    )


@pytest.mark.parametrize("dimension", [2, 3])
def test_the_other_end_first(dimension: int) -> None:
    scene = coil(edges=60, stop='"0.4 pi"', dimension=dimension)
    run = push_from(scene, lambda state: state)
    image = push_from(scene, lambda state: from_the_other_end(state, 10.0))
    assert len(run) == len(image)
    for name in NUMBERS:
        np.testing.assert_allclose(image.table[name], run.table[name], rtol=1e-8, atol=1e-9)


@pytest.mark.parametrize("bending", [1.0, 3.0, 0.7e-3, 123.456])
def test_states_go_to_frames_and_back(bending: float) -> None:
    """What is recorded comes back to the last digit or two, and what comes back is recorded alike."""
    scene = coil(edges=40).replace(
        {
            "rod.bending": bending,
            "rod.twisting": 0.9 * bending,
            "drop.capillary_force": 20 * bending,
            "drop.wall_strength": 2e-4 * bending,
            "push.stop": "0.3 pi",
        }
    )
    run = derod.push(scene)
    system = System(scene)
    assert run.table["converged"].all()
    for i in (0, len(run) // 2, len(run) - 1):
        frame = driver.frame_of(run, i)
        state = decode(system, frame, slides=False)
        here = measure(system, state, CONTROLS["end_shortening"])
        assert here.settled
        fields = {n: frame.row[n] for n in ("increment", "segment", "smooth", "landing")}
        again = encode(
            system,
            here,
            Settled(
                **fields, residual=0.0, work_defect=0.0, iterations=0, next_step=0.0, wall_time=0.0
            ),
        )  # fmt: skip
        np.testing.assert_array_equal(again.positions, frame.positions)
        np.testing.assert_allclose(again.edge_tension, frame.edge_tension, rtol=1e-15)
        for name in (*NUMBERS, "force_a", "force_b", "wall_gap", "turning_angle"):
            assert again.row[name] == pytest.approx(frame.row[name], rel=1e-12), name
        twice = decode(system, again, slides=False)
        np.testing.assert_allclose(twice.q, state.q, rtol=1e-15)
