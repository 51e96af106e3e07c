"""Steps along the wall: ``stay_inside``."""

from __future__ import annotations

import numpy as np
import pytest

from derod.rod.terms.wall import stay_inside, wall_gap
from tests.rod.states import Sample

RADIUS = 0.549  # D; the wall is singular at 0.55


def on_the_wall(d: int) -> Sample:
    """Put the wetted nodes on an arc of ``RADIUS``."""
    sample = Sample(d)
    kin = sample.room.kin
    angle = np.linspace(0, np.pi, kin.node_b - kin.node_a + 1)
    ring = sample.q[kin.node_a : kin.node_b + 1]
    ring[:, :d] = sample.b[2 : 2 + d]
    ring[:, d - 1] -= RADIUS * np.cos(angle)
    ring[:, d - 2] += RADIUS * np.sin(angle)
    return sample


def moved(sample: Sample, along: float, outward: float) -> np.ndarray:
    """Return q with each wetted node moved along the wall and outward."""
    kin, d = sample.room.kin, sample.d
    wetted = slice(kin.node_a, kin.node_b + 1)
    arm = (sample.q[wetted, :d] - sample.b[2 : 2 + d]) / RADIUS
    turned = np.zeros_like(arm)
    turned[:, d - 1], turned[:, d - 2] = arm[:, d - 2], -arm[:, d - 1]
    q = sample.q.copy()
    q[wetted, :d] += along * turned + outward * arm
    return q


def radii(sample: Sample, q: np.ndarray) -> np.ndarray:
    kin, d = sample.room.kin, sample.d
    return np.linalg.norm(q[kin.node_a : kin.node_b + 1, :d] - sample.b[2 : 2 + d], axis=1)


@pytest.mark.parametrize("d", [2, 3])
def test_a_step_along_the_wall_keeps_its_distance(d: int) -> None:
    sample = on_the_wall(d)
    q = moved(sample, 0.1, -1e-4)
    assert wall_gap(sample.physics, sample.room.kin, q, sample.b) < 0
    stay_inside(sample.physics, sample.room.kin, sample.q, sample.b, q, sample.b)
    np.testing.assert_allclose(radii(sample, q), RADIUS - 1e-4, atol=1e-14)


def test_the_step_is_changed_to_second_order_only() -> None:
    sample = on_the_wall(2)
    changes = []
    for s in (0.1, 0.05):
        straight = moved(sample, s, 0.0)
        q = straight.copy()
        stay_inside(sample.physics, sample.room.kin, sample.q, sample.b, q, sample.b)
        changes.append(np.abs(q - straight).max())
    assert changes[0] / changes[1] == pytest.approx(4, rel=0.02)


def test_short_steps_and_the_drops_own_motion_are_left_alone() -> None:
    sample = on_the_wall(2)
    b = sample.b.copy()
    b[2:4] += 0.2  # the drop and all nodes move together
    for q, centre in ((moved(sample, 0.01, -1e-4), sample.b), (sample.q.copy(), b)):
        if centre is b:
            q[:, :2] += 0.2
        before = q.copy()
        stay_inside(sample.physics, sample.room.kin, sample.q, sample.b, q, centre)
        np.testing.assert_array_equal(q, before)
