"""The count of unstable modes, the branch's slope and the lowest mode against dense algebra."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.linalg import eigh, null_space

import derod
from derod.equilibrium.measured import measure
from derod.equilibrium.stability import inertia, lowest_mode, sliding_stiffness
from derod.equilibrium.system import System
from derod.pushing.controls import CONTROLS
from derod.pushing.driver import frame_of
from derod.pushing.encode import decode
from derod.rod.state import State
from derod.rod.unknowns import X_C
from tests.rod.states import dense

SCENE = """
[rod]
length = 6
bending = 1
twisting = 0.9
[drop]
capillary_force = 20
wall_strength = 2e-2
wall_softness = 0.1
[push]
start = "0.01 pi"
stop = "{stop} pi"
max_step = "0.02 pi"
[mesh]
edges = 60
[noise]
amplitude = 0
"""


def settled(stop: float) -> tuple[System, State]:
    """A planar rod, followed without noise past its pitchfork at 0.24 pi."""
    scene = derod.parse_scene(SCENE.format(stop=stop))
    run = derod.push(scene)
    return System(scene), decode(System(scene), frame_of(run, len(run) - 1))


@pytest.fixture(scope="module")
def unstable() -> tuple[System, State]:
    return settled(0.4)


def eigenvalues_on_the_constraints(system: System, state: State) -> np.ndarray:
    """The Hessian's eigenvalues where all constraints hold, in the metric of ``inertia``, dense.

    The border's last two rows are the twisting moment (which is no constraint but a rank-one part) and
    the turn about the clamp axis, which is left out of the space as its deflation does.
    """
    system.linearise(state)
    d, n = system.dimension, system.edges
    matrix = dense(system.room.linear)
    rows = n * (d + 1)
    moment, turn = rows + d + 5, rows + d + 6
    matrix[:moment, :moment] -= (
        np.outer(matrix[:moment, moment], matrix[moment, :moment]) / matrix[moment, moment]
    )
    weight, border = inertia(system, state)
    metric = np.concatenate([weight.ravel(), border])
    moves = np.flatnonzero(metric > 0)
    multipliers = [(d + 1) * e + d for e in range(n)] + [rows + 2 + d + k for k in range(3)]
    space = null_space(np.vstack([matrix[np.ix_([*multipliers, turn], moves)]]))
    hessian = space.T @ matrix[np.ix_(moves, moves)] @ space
    return eigh(hessian, space.T @ (metric[moves, None] * space), eigvals_only=True)


def test_the_count_is_that_of_dense_eigenvalues(unstable) -> None:
    system, state = unstable
    values = eigenvalues_on_the_constraints(system, state)
    assert (
        np.sum(values < 0) == measure(system, state, CONTROLS["end_shortening"]).unstable_modes >= 1
    )


def test_the_lowest_mode_is_an_eigenvector(unstable) -> None:
    system, state = unstable
    values = eigenvalues_on_the_constraints(system, state)
    start = np.random.default_rng(0).standard_normal(state.q.shape)
    value, mode_q, mode_b = lowest_mode(system, state, start)
    assert value == pytest.approx(values[0], rel=1e-8)
    assert np.abs(mode_q[:, :3]).max() == pytest.approx(1, rel=1e-12)
    assert not mode_q[:, 3].any() and not mode_b[5:].any()
    assert not mode_q[[0, -1]].any()
    # out of the plane, where a planar state is lost
    assert np.abs(mode_q[:, 0]).max() > 0.5


def test_a_stable_state_has_no_negative_eigenvalue() -> None:
    system, state = settled(0.1)
    assert measure(system, state, CONTROLS["end_shortening"]).unstable_modes == 0
    assert eigenvalues_on_the_constraints(system, state)[0] > 0


def test_the_slope_is_the_difference_of_neighbours() -> None:
    system, state = settled(0.2)
    here = measure(system, state, CONTROLS["end_shortening"])
    from derod.equilibrium.loop import relax
    from derod.equilibrium.methods import make_relaxer

    step = 1e-5
    sides = []
    for sign in (1, -1):
        guess = state.copy()
        guess.clamp_at(state.end_shortening + sign * step)
        solution = relax(make_relaxer("implicit"), system, guess, 1e-13)
        sides.append(solution.state)
    slope = (sides[0].q - sides[1].q) / (2 * step)
    np.testing.assert_allclose(here.slope_q, slope, atol=1e-5 * np.abs(slope).max())
    slope = (sides[0].b - sides[1].b) / (2 * step)
    np.testing.assert_allclose(here.slope_b, slope, atol=1e-5 * np.abs(slope).max())


def test_sliding_stiffness_is_that_of_the_released_pin(unstable: tuple[System, State]) -> None:
    """k = 4 / (c K^-1 c), K without the pin's row c; K has one negative eigenvalue more where k < 0."""
    system, state = unstable
    system.linearise(state)
    matrix = dense(system.room.linear)
    pin = system.edges * (system.dimension + 1) + X_C + system.dimension + 2
    released = np.delete(np.delete(matrix, pin, 0), pin, 1)
    row = np.delete(matrix[:, pin], pin)
    wanted = 4.0 / (row @ np.linalg.solve(released, row))
    assert sliding_stiffness(system) == pytest.approx(wanted, rel=1e-3)
    counts = [int((np.linalg.eigvalsh(m) < 0).sum()) for m in (matrix, released)]
    assert counts[1] == counts[0] - 1 + (wanted < 0)
