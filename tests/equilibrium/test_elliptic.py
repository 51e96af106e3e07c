"""The elliptic mass: what it is made of, its spectrum, and that steps do not grow with the mesh."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.interpolate
import scipy.linalg

import derod
from derod.equilibrium.elliptic_mass import CENTRE, fill_operator
from derod.equilibrium.loop import Outcome, relax
from derod.equilibrium.measured import measure
from derod.equilibrium.methods import make_relaxer
from derod.equilibrium.system import System
from derod.pushing.controls import CONTROLS
from derod.pushing.driver import frame_of
from derod.pushing.encode import decode
from derod.pushing.guess import bent_guess
from derod.pushing.predict import predict
from derod.rod.state import State
from tests.equilibrium.test_explicit import disturbed, settled
from tests.scenes import coil

DRY = """
[rod]
length = 1
bending = 1
twisting = 0.9
[push]
start = "0.01"
stop = 0.3
[mesh]
edges = 40
[model]
drop = false
dimension = {dimension}
"""
MESHES = (32, 64, 128)
STOPS = (0.1, 0.5, 1.0)  # pi


def dense(system: System) -> tuple[np.ndarray, np.ndarray]:
    """The matrix in the room on x_1 ... x_{N-1}, s_A, s_B, x_C, twist eliminated; and the constraints."""
    linear, d, n = system.room.linear, system.dimension, system.edges
    rows = (d + 1) * n
    borders = linear.corner.shape[0]
    full = np.zeros((rows + borders, rows + borders))
    for k in range(linear.band.shape[1]):
        for j in range(rows - k):
            full[j + k, j] = full[j, j + k] = linear.band[j, k]
    full[:rows, rows:] = linear.border[:rows]
    full[rows:, :rows] = linear.border[:rows].T
    full[rows:, rows:] = linear.corner
    moving = [(d + 1) * (i - 1) + k for i in range(1, n) for k in range(d)]
    moving += [rows + k for k in range(2 + d)]
    held = [(d + 1) * (e - 1) + d for e in range(1, n + 1)] + [rows + 2 + d + k for k in range(3)]
    matrix = full[np.ix_(moving, moving)]
    if d == 3:
        twist = full[rows + d + 5][moving]
        matrix = matrix - np.outer(twist, twist) / full[rows + d + 5, rows + d + 5]
    return matrix, full[np.ix_(held, moving)]


def operator(system: System, state: State) -> tuple[np.ndarray, np.ndarray]:
    """M and A at a state."""
    system.gradient(state)
    fill_operator(system.physics, state.q, state.b, system.room, system.factor)
    return dense(system)


def spectrum(system: System, state: State) -> np.ndarray:
    """Eigenvalues of M^-1 H on the constraints, in rising order."""
    system.linearise(state)
    hessian, rows = dense(system)
    mass, own_rows = operator(system, state)
    assert own_rows == pytest.approx(rows, abs=1e-14)
    free = scipy.linalg.null_space(rows)
    return scipy.linalg.eigvalsh(free.T @ hessian @ free, free.T @ mass @ free)


@pytest.fixture(scope="module", params=[2, 3])
def coils(request: pytest.FixtureRequest) -> list[tuple[System, list[State]]]:
    """States of the paper's rod at STOPS, on every mesh; planar ones are followed past Ax's pitchfork."""
    found = []
    for edges in MESHES:
        scene = coil(
            edges=edges,
            dimension=request.param,
            noise=1e-3 if request.param == 3 else 0.0,
            at=str([f"{stop} pi" for stop in STOPS[:-1]]),
            stop=f'"{STOPS[-1]} pi"',
        )
        run, system = derod.push(scene), System(scene)
        rows = [int(abs(run.table["end_shortening"] - stop * np.pi).argmin()) for stop in STOPS]
        found.append((system, [decode(system, frame_of(run, i)) for i in rows]))
    return found


def test_spectrum_does_not_know_the_mesh(coils: list[tuple[System, list[State]]]) -> None:
    """In [0.04, 1.4], but for the neutral turn about the clamp axis; alike on all meshes."""
    lowest, highest = [], []
    for system, states in coils:
        for state in states:
            values = spectrum(system, state)
            neutral = values[abs(values) < 1e-7]
            assert neutral.size == (1 if system.dimension == 3 else 0)
            others = values[abs(values) >= 1e-7]
            lowest.append(others[0])
            highest.append(others[-1])
    assert min(lowest) > 0.04
    assert max(highest) < 1.4
    coarse, _, fine = np.split(np.array(lowest), 3)
    assert fine == pytest.approx(coarse, rel=0.1)
    coarse, _, fine = np.split(np.array(highest), 3)
    assert np.all(fine < coarse * 1.02)


def test_it_is_the_straight_rods_bending() -> None:
    """Where a rod is straight and free of tension, M is the Hessian across it; along, M is the same."""
    system = System(derod.parse_scene(DRY.format(dimension=2)))
    state = bent_guess(system, system.physics, 0.0)
    state.q[:, 0] = 0.0
    state.q[:, 1] = np.linspace(0, 1, system.edges + 1)
    state.q[:, 2] = 0.0
    system.linearise(state)
    hessian, _ = dense(system)
    mass, _ = operator(system, state)
    across, along = slice(0, 2 * (system.edges - 1), 2), slice(1, 2 * (system.edges - 1), 2)
    size = abs(hessian).max()
    assert mass[across, across] == pytest.approx(hessian[across, across], abs=1e-12 * size)
    assert mass[along, along] == pytest.approx(mass[across, across], abs=1e-12 * size)
    assert abs(mass[across, along]).max() == 0.0


@pytest.mark.parametrize("dimension", [2, 3])
def test_sliding_through_its_own_shape_weighs_little(dimension: int) -> None:
    """Nodes carried by the wetted length leave the shape as it is: only that length's own mass is left."""
    system = System(coil(edges=40, dimension=dimension))
    state = settled(system, 0.1 * np.pi)
    mass, rows = operator(system, state)
    twist = np.zeros_like(mass)
    d, n = dimension, system.edges
    if d == 3:
        column = system.room.linear.border[:, d + 5]
        across = np.zeros(mass.shape[0])
        across[: d * (n - 1)] = column[: (d + 1) * (n - 1)].reshape(-1, d + 1)[:, :d].ravel()
        twist = np.outer(across, across) * system.physics.twisting / system.physics.length
    h = 1e-5
    places = []
    for sign in (1, -1):  # where a smooth curve through the nodes has them, g = +-h
        moved = state.copy()
        moved.b[:2] += sign * h * np.array([-1.0, 1.0])
        places.append(system.arc_length(moved))
    curve = scipy.interpolate.CubicSpline(
        system.arc_length(state), state.q[:, :d], bc_type=((1, np.eye(d)[-1]),) * 2
    )
    carried = np.zeros(mass.shape[0])
    carried[: d * (n - 1)] = ((curve(places[0]) - curve(places[1])) / (2 * h))[1:-1].ravel()
    carried[d * (n - 1) : d * (n - 1) + 2] = -1.0, 1.0
    own = CENTRE + 2 * sum(abs(f) for f in state.forces)
    assert carried @ (mass - twist) @ carried == pytest.approx(own, rel=0.05)
    stiffest = abs(rows[:n] @ carried).max()
    assert stiffest < 0.02 * abs(rows[:n, -d - 2 : -d]).max()  # and strains no edge


@pytest.mark.parametrize("dimension", [2, 3])
def test_the_elastica_without_a_drop(dimension: int) -> None:
    system = System(derod.parse_scene(DRY.format(dimension=dimension)))
    start = bent_guess(system, system.physics, 0.2)
    ends = [relax(make_relaxer(method), system, start) for method in ("implicit", "elliptic")]
    assert all(end.converged for end in ends), [end.message for end in ends]
    energies = [system.energies(end.state).total for end in ends]
    assert energies[1] == pytest.approx(energies[0], rel=1e-10)
    tensions = []
    for end in ends:
        system.gradient(end.state)
        tensions.append(system.end_tension(end.state))
    assert tensions[1] == pytest.approx(tensions[0], rel=1e-8)


def test_steps_do_not_grow_with_the_mesh() -> None:
    """From the same prediction, at most like N^0.2."""
    steps = []
    meshes = (50, 400)
    for edges in meshes:
        system = System(coil(edges=edges))
        near = settled(system, 0.15 * np.pi)
        control = CONTROLS["end_shortening"]
        guess = predict(system, control, measure(system, near, control), None, 0.17 * np.pi)
        solution = relax(make_relaxer("elliptic"), system, disturbed(guess, 1e-3))
        assert solution.converged, solution.message
        steps.append(solution.iterations)
    assert steps[1] <= steps[0] * (meshes[1] / meshes[0]) ** 0.2


def test_strained_edges_are_brought_back_first() -> None:
    """A state whose edges are off by a tenth comes to rest at the equilibrium nearby."""
    system = System(coil(edges=40))
    expected = settled(system, 0.15 * np.pi)
    start = expected.copy()
    rng = np.random.default_rng(3)
    rest = system.rest_lengths(start)
    start.q[1:-1, :3] += (
        0.1 * np.minimum(rest[1:], rest[:-1])[:, None] * rng.uniform(-1, 1, (system.edges - 1, 3))
    )
    solution = relax(make_relaxer("elliptic"), system, start)
    assert solution.converged, solution.message
    assert system.energy_hat(solution.state) == pytest.approx(system.energy_hat(expected), abs=1e-9)


def test_a_vertex_bent_backward_is_given_up() -> None:
    """A turning angle beyond a right angle changes the link of the ends: no state to relax from."""
    system = System(coil(edges=40))
    start = settled(system, 0.15 * np.pi)
    start.q[-1, 2] -= 1.5 * system.rest_lengths(start)[-1]
    solution = relax(make_relaxer("elliptic"), system, start)
    assert solution.outcome is Outcome.STALLED
    assert solution.iterations == 0


def test_says_when_it_ran_out_of_steps() -> None:
    system = System(coil(edges=40))
    relaxer = make_relaxer("elliptic")
    relaxer.limit = 7
    solution = relax(relaxer, system, disturbed(settled(system, 0.15 * np.pi), 1e-3))
    assert solution.outcome is Outcome.MAX_ITERATIONS
    assert solution.iterations == 7
    system.gradient(solution.state)
    assert system.excess(solution.state, relaxer.finest)[1] == pytest.approx(
        solution.residual, rel=1e-12
    )
