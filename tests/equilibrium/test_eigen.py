"""The lowest eigenpairs against dense algebra, and against closed forms of straight rods."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.linalg import eigh, null_space
from scipy.optimize import brentq, minimize_scalar

import derod
from derod.equilibrium import eigen
from derod.equilibrium.loop import relax
from derod.equilibrium.methods import make_relaxer
from derod.equilibrium.system import System
from derod.record.modes import state_of
from derod.rod.state import State
from derod.rod.unknowns import BORDER
from tests.rod.states import dense
from tests.scenes import coil


def eigenvalues_dense(system: System, state: State) -> np.ndarray:
    """All eigenvalues on the constraints' null space, the turn left out where it is neutral."""
    _, metric = eigen.factor_shifted(system, state, 0.0)
    d, n = system.dimension, system.edges
    matrix, rows = dense(system.room.linear), n * (d + 1)
    moves = [(d + 1) * i + k for i, k in zip(*np.nonzero(metric.weight), strict=True)]
    moves += [rows + k for k in range(2 + d)] if metric.drop else []
    weights = np.zeros_like(matrix)
    for j in moves:
        unit = np.zeros(len(matrix))
        unit[j] = 1
        own, border = metric.weighed(unit[:rows].reshape(n, d + 1), unit[rows:])
        weights[:, j] = np.concatenate([own.ravel(), border])
    held = [(d + 1) * e + d for e in range(n)]
    held += [rows + 2 + d + k for k in range(3)] if metric.drop else []
    if d == 3:
        moment, turn = rows + d + 5, rows + d + 6
        column = matrix[:moment, moment].copy()
        matrix[:moment, :moment] -= np.outer(column, column) / matrix[moment, moment]
        held += [turn] if eigen.turns_freely(state) else []
    space = null_space(matrix[np.ix_(held, moves)])
    inside = np.ix_(moves, moves)
    return eigh(
        space.T @ matrix[inside] @ space, space.T @ weights[inside] @ space, eigvals_only=True
    )


SCENES = {
    "stable": coil(edges=40, stop='"0.4 pi"'),
    "unstable": coil(edges=40, stop='"0.4 pi"', noise=0.0),
    "turned": coil(edges=40, stop='"0.6 pi"', rotation=2.0),
    "planar": coil(edges=40, stop='"0.3 pi"', dimension=2),
    "heavy": coil(edges=40, stop='"0.3 pi"').replace({"drop.weight": 2.0}),
}


@pytest.mark.parametrize("name", SCENES)
def test_eigenvalues_and_inertia_are_those_of_dense_algebra(name: str) -> None:
    run = derod.push(SCENES[name])
    system, state = state_of(run, -1)
    exact = eigenvalues_dense(system, state)
    found = eigen.lowest(system, state, 6)
    assert found.values == pytest.approx(exact[:6], rel=1e-7)
    assert np.sum(exact < 0) == run.table["unstable_modes"][-1] == (name == "unstable")
    for k in range(5):  # the count at a shift between two eigenvalues
        middle = 0.5 * (exact[k] + exact[k + 1])
        assert eigen.factor_shifted(system, state, -middle)[0] == k + 1
    metric = eigen.Metric(system, state)
    empty = np.zeros(system.factor.rhs_border.size - state.b.size)
    moved = [metric.down(q[1:], np.append(b, empty)) for q, b in zip(found.q, found.b, strict=True)]
    assert abs(np.array(moved) @ np.array(moved).T - np.eye(6)).max() < 1e-8


def test_the_norm_is_that_of_the_material() -> None:
    """Nodes that slide along the rod with a meniscus move no material, but for the chord's curvature."""
    system, state = state_of(derod.push(coil(edges=100, stop='"0.3 pi"')), -1)
    system.gradient(state)
    metric = eigen.Metric(system, state)
    border = np.zeros(system.factor.rhs_border.size)
    border[0] = 1.0
    rows = np.zeros((system.edges, 4))
    rows[:, :3] = metric.carried[0]
    assert np.linalg.norm(metric.down(rows, border)) < 1e-14
    # the same curve on moved nodes: dx = t ds to second order in ds
    step = 1e-4
    s = system.arc_length(state)
    moved = state.copy()
    moved.b[0] += step
    system.gradient(moved)
    along = system.arc_length(moved) - s
    assert (along[1:] / step) == pytest.approx(
        np.linalg.norm(metric.carried[0], axis=1), rel=1e-3, abs=1e-3
    )


def straight(edges: int, length: float, tension: float, twisting: float, turn: float) -> tuple:
    """A straight, twisted rod of bending stiffness 1 under a dead load.

    Its end may slide: between fixed clamps an inextensible straight rod's tension is not determined.
    """
    scene = derod.Scene(
        rod={"length": length, "bending": 1.0, "twisting": twisting},
        clamps={"end_tension": tension},
        push={"control": "end_rotation", "start": turn, "stop": turn + 1.0, "at": []},
        mesh={"edges": edges},
        model={"drop": False},
    )
    system = System(scene)
    q = np.zeros((edges + 1, 4))
    q[:, 2] = np.linspace(0, length, edges + 1)
    q[1:, 3] = tension
    physics = system.physics._replace(end_rotation=turn)
    state = State(q, np.zeros(BORDER + 3), 0.0, 0.0, physics)
    assert relax(make_relaxer("implicit"), system, state).iterations == 0, "settled as it is"
    return system, state


def exact_straight(length: float, tension: float, moment: float, count: int) -> np.ndarray:
    """The lowest eigenvalues of w'''' - T w'' - i M w''' = lambda w, w = x + i y, w = w' = 0 at both ends.

    w = sum a_j e^{i k_j s} with k^4 - M k^3 + T k^2 = lambda: zeros of the determinant of the ends.
    """

    def singular(value: float) -> float:
        k = np.roots([1.0, -moment, tension, 0.0, -value])
        ends = np.exp(1j * (k * length) - np.abs(np.imag(k * length)))
        start = np.exp(-np.abs(np.imag(k * length)))
        matrix = np.array([start, k * start, ends, k * ends])
        return float(np.linalg.svd(matrix / np.linalg.norm(matrix, axis=0), compute_uv=False)[-1])

    scale = (np.pi / length) ** 4
    grid = scale * np.linspace(-9.0, 150.0, 3001)
    values = np.array([singular(x) for x in grid])
    dips = np.flatnonzero((values[1:-1] < values[:-2]) & (values[1:-1] < values[2:])) + 1
    found = []
    for dip in dips:
        best = minimize_scalar(
            singular, bounds=(grid[dip - 1], grid[dip + 1]), method="bounded",
            options={"xatol": 1e-10 * scale},
        )  # fmt: skip
        if best.fun < 1e-6 and abs(best.x) > 1e-3 * scale:
            found.append(best.x)
    return np.array(found[:count])


@pytest.mark.parametrize("seed", range(6))
def test_straight_rods_compressed_and_twisted(seed: int) -> None:
    """In pairs, since any turn of a mode about the axis is one; fourth order in the edges."""
    rng = np.random.default_rng([16, seed])
    length, twisting = rng.uniform(0.5, 3.0), rng.uniform(0.5, 1.5)
    tension = rng.uniform(-6.0, 3.0) * (np.pi / length) ** 2
    moment = rng.uniform(-2.0, 2.0) * np.pi / length
    exact = exact_straight(length, tension, moment, 2)
    assert len(exact) == 2
    errors = []
    for edges in (30, 60):
        system, state = straight(edges, length, tension, twisting, moment * length / twisting)
        found = eigen.lowest(system, state, 4).values
        assert np.sum(found < 0) == 2 * np.sum(exact < 0)
        assert found[::2] == pytest.approx(found[1::2], rel=1e-7)
        scale = abs(exact) + (np.pi / length) ** 4
        errors.append((abs(found[::2] - exact) / scale).max())
    assert errors[1] < 2e-4 and errors[1] < errors[0] / 6


def test_euler_and_greenhill() -> None:
    """The lowest eigenvalue vanishes at the clamped rod's Euler load and at the twist threshold."""

    def lowest(tension: float, moment: float) -> float:
        system, state = straight(120, 1.0, tension, 1.0, moment)
        return float(eigen.lowest(system, state, 1).values[0])

    assert brentq(lambda p: lowest(-p, 0.0), 30, 50) == pytest.approx(4 * np.pi**2, rel=2e-5)
    assert brentq(lambda m: lowest(0.0, m), 7, 10) == pytest.approx(8.98682, rel=2e-5)


def test_what_is_refused() -> None:
    system, state = straight(12, 1.0, 1.0, 1.0, 0.0)
    most = eigen.most_modes(system, state)
    assert eigen.lowest(system, state, most).values.size == most
    with pytest.raises(
        eigen.ModesError, match=f"k = {most + 1}: allowed: 1 to {most}, on 12 edges"
    ):
        eigen.lowest(system, state, most + 1)
