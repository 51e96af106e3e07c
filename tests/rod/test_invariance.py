"""The energy does not see a turn about the clamp axis, a mirror, or which end is called the first."""

from __future__ import annotations

import numpy as np
import pytest

from derod.rod import assembly
from tests.rod.states import LENGTH, Sample


def parts(sample: Sample, q: np.ndarray, b: np.ndarray, rotation: float) -> np.ndarray:
    physics = sample.physics._replace(end_rotation=rotation, weight=0.0)
    psi, sound = assembly.gradient(physics, sample.mesh, q, b, 0.0, sample.room)
    assert sound
    return np.array(assembly.energies(physics, q, b, psi, sample.room))


def test_turn_about_the_axis() -> None:
    sample = Sample(3)
    turn = np.array([[np.cos(0.7), -np.sin(0.7), 0], [np.sin(0.7), np.cos(0.7), 0], [0, 0, 1]])
    q, b = sample.q.copy(), sample.b.copy()
    q[:, :3] = q[:, :3] @ turn.T
    b[2:5] = turn @ b[2:5]
    np.testing.assert_allclose(
        parts(sample, q, b, 1.0), parts(sample, sample.q, sample.b, 1.0), rtol=1e-12
    )


def test_mirror_turns_the_twist_around() -> None:
    sample = Sample(3)
    q, b = sample.q.copy(), sample.b.copy()
    q[:, 0] *= -1
    b[2] *= -1
    np.testing.assert_allclose(
        parts(sample, q, b, -1.0), parts(sample, sample.q, sample.b, 1.0), rtol=1e-12
    )


@pytest.mark.parametrize("d", [2, 3])
def test_either_end_may_be_the_first(d: int) -> None:
    sample = Sample(d)
    q, b = sample.q.copy(), sample.b.copy()
    top = sample.q[-1, d - 1]
    q[:, :d] = sample.q[::-1, :d]
    q[:, d - 1] = top - q[:, d - 1]
    if d == 3:  # a half turn about an axis across, which keeps the handedness
        q[:, 0] *= -1
        b[2] *= -1
    b[0], b[1] = LENGTH - sample.b[1], LENGTH - sample.b[0]
    b[1 + d] = top - sample.b[1 + d]
    np.testing.assert_allclose(
        parts(sample, q, b, 1.0), parts(sample, sample.q, sample.b, 1.0), rtol=1e-11
    )


def test_planar_rod_costs_the_same_in_space() -> None:
    plane, space = Sample(2), Sample(3)
    space.q[:, 1:] = plane.q
    space.q[:, 0] = 0
    space.b[2] = 0
    np.testing.assert_allclose(
        parts(plane, plane.q, plane.b, 0.0), parts(space, space.q, space.b, 0.0), rtol=1e-13
    )


def test_planar_rod_feels_no_force_out_of_its_plane() -> None:
    sample = Sample(3)
    sample.q[:, 0] = 0
    sample.b[2] = 0
    physics = sample.physics._replace(end_rotation=0.0)
    assembly.gradient(physics, sample.mesh, sample.q, sample.b, 0.0, sample.room)
    assert (sample.room.r[:, 0] == 0).all()
    assert sample.room.rb[2] == 0
