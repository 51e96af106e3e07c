"""Gradient and Hessian of the whole Lagrangian against central differences."""

from __future__ import annotations

import numpy as np
import pytest

from tests.rod.states import Sample

STEP = 1e-5
STENCIL = ((1, 8 / 12), (-1, -8 / 12), (2, -1 / 12), (-2, 1 / 12))  # of a central difference


def near_the_wall(sample: Sample) -> None:
    """Put the wetted nodes on a ring just inside the wall's singularity at r = 0.55."""
    kin, d = sample.room.kin, sample.d
    angle = np.linspace(-0.4, np.pi + 0.4, kin.node_b - kin.node_a + 1)
    ring = sample.q[kin.node_a : kin.node_b + 1]
    ring[:, d - 1] = sample.b[1 + d] - 0.545 * np.cos(angle)
    ring[:, d - 2] = 0.545 * np.sin(angle)
    ring[:, : d - 2] *= 0.1


def wound(turns: float, wide: float, holonomy: float) -> Sample:
    """A wide helix that remembers its holonomy's branch."""
    sample = Sample(3, edges=60, turns=turns)
    sample.q[:, :2] *= wide
    sample.psi = holonomy
    return sample


def samples() -> dict[str, Sample]:
    """States that stress one thing each."""
    made = {f"{d}d": Sample(d) for d in (2, 3)}
    made["dry"] = Sample(3, drop=False)
    made["holonomy near pi"] = wound(10, 0.9, 3.0)
    made["holonomy past 2 pi"] = wound(20, 0.9, 7.0)
    for d in (2, 3):
        made[f"wall {d}d"] = Sample(d)
        near_the_wall(made[f"wall {d}d"])
    return made


SAMPLES = samples()


@pytest.fixture(params=SAMPLES, scope="module")
def sample(request: pytest.FixtureRequest) -> Sample:
    return SAMPLES[request.param]


def moved(sample: Sample, place: int, step: float) -> tuple[np.ndarray, np.ndarray]:
    q, b = sample.q.copy(), sample.b.copy()
    n = (sample.d + 1) * sample.edges
    if place < n:
        q[1:].reshape(-1)[place] += step
    else:
        b[place - n] += step
    return q, b


def places(sample: Sample) -> np.ndarray:
    """The unknowns to move; without a drop b is idle."""
    free = sample.free()
    return free if sample.physics.drop else free[free < (sample.d + 1) * sample.edges]


def test_gradient(sample: Sample) -> None:
    exact = sample.gradient(sample.q, sample.b).copy()
    scale = np.abs(exact).max()
    for place in places(sample):
        found = sum(w * sample.lagrangian(*moved(sample, place, k * STEP)) for k, w in STENCIL)
        assert found / STEP == pytest.approx(exact[place], abs=2e-8 * scale + 1e-7)


def test_hessian(sample: Sample) -> None:
    matrix = sample.dense()
    size = (sample.d + 1) * sample.edges + sample.d + 5
    exact = matrix[:size, :size].copy()
    if sample.d == 3:  # the border row of the twisting moment is k3/l grad psi grad psi
        moment = matrix[:size, size]
        exact -= np.outer(moment, moment) / matrix[size, size]
    rows = places(sample)
    scale = np.abs(exact).max()
    for place in rows:
        column = sum(w * sample.gradient(*moved(sample, place, k * STEP)) for k, w in STENCIL)
        np.testing.assert_allclose(
            column[rows] / STEP, exact[rows, place], atol=1e-8 * scale, rtol=0
        )


def test_holonomy_samples_are_where_they_say() -> None:
    for name, low, high in (("holonomy near pi", 2.8, 3.5), ("holonomy past 2 pi", 6.4, 12.0)):
        made = SAMPLES[name]
        made.gradient(made.q, made.b)
        assert low < abs(made.followed) < high, made.followed
