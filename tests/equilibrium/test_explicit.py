"""Explicit relaxation lands where the implicit one does, and says how it ended."""

from __future__ import annotations

import numpy as np
import pytest

import derod
from derod.equilibrium import dynamics as explicit
from derod.equilibrium import masses
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
from tests.scenes import coil

NEAR, FAR = 0.10 * np.pi, 0.12 * np.pi


def disturbed(state: State, size: float, seed: int = 0) -> State:
    """A copy with its free nodes moved smoothly, in all directions, by about ``size`` (D)."""
    rng = np.random.default_rng(seed)
    d, n = state.dimension, state.q.shape[0] - 1
    place = np.linspace(0, np.pi, n + 1)[1:-1]
    moved = state.copy()
    for wave in range(1, 6):
        moved.q[1:-1, :d] += size / wave * np.outer(np.sin(wave * place), rng.normal(size=d))
    return moved


def settled(system: System, delta: float) -> State:
    """The implicit equilibrium."""
    solution = relax(
        make_relaxer("implicit"), system, bent_guess(system, system.physics, delta), descend=True
    )
    assert solution.converged
    return solution.state


@pytest.fixture(scope="module", params=[2, 3])
def pushed(request: pytest.FixtureRequest) -> tuple[System, State, State]:
    """A system, the prediction at FAR and the implicit equilibrium there."""
    system = System(coil(edges=40, dimension=request.param))
    near = settled(system, NEAR)
    control = CONTROLS["end_shortening"]
    guess = predict(system, control, measure(system, near, control), None, FAR)
    solution = relax(make_relaxer("implicit"), system, guess)
    assert solution.converged
    return system, guess, solution.state


@pytest.mark.parametrize("method", ["fire", "kinetic", "elliptic"])
@pytest.mark.parametrize("size", [0.0, 1e-3])
def test_lands_on_the_implicit_state(
    pushed: tuple[System, State, State], method: str, size: float
) -> None:
    system, guess, expected = pushed
    solution = relax(make_relaxer(method), system, disturbed(guess, size))
    assert solution.converged, solution.message
    assert system.energy_hat(solution.state) == pytest.approx(system.energy_hat(expected), abs=1e-7)
    tension = []
    for state in (solution.state, expected):
        system.gradient(state)
        tension.append(system.end_tension(state))
    assert tension[0] == pytest.approx(tension[1], abs=1e-5)


@pytest.mark.parametrize("method", ["fire", "kinetic", "elliptic"])
def test_leaves_an_unstable_planar_state(method: str) -> None:
    """Past the pitchfork a disturbed planar rod goes down to the coil in space, a minimum."""
    scene = coil(edges=40, stop='"0.3 pi"', noise=0.0)  # Newton's steps stay in the plane
    run = derod.push(scene)
    system = System(scene)
    state = decode(system, frame_of(run, len(run) - 1))
    assert measure(system, state, CONTROLS["end_shortening"]).unstable_modes > 0
    solution = relax(make_relaxer(method), system, disturbed(state, 1e-3))
    assert solution.converged, solution.message
    assert measure(system, solution.state, CONTROLS["end_shortening"]).unstable_modes == 0
    assert system.energy_hat(solution.state) < system.energy_hat(state) - 1e-3


def test_the_step_is_stable(pushed: tuple[System, State, State]) -> None:
    """Leapfrog with the step 1 needs eigenvalues of M^-1 H below 4; H by differences."""
    system, _, state = pushed
    d, n = system.dimension, system.edges
    inertia, motion = masses.new_inertia(n, d), explicit.new_motion(n, d)
    system.gradient(state)
    masses.fill_masses(
        system.physics,
        state.q,
        state.b,
        state.holonomy,
        system.room,
        system.factor,
        inertia,
    )
    motion.tension[:] = state.q[:, d]
    motion.force[:] = state.b[2 + d : 4 + d]
    size = d * (n - 1) + 1 + d

    def forces(z: np.ndarray) -> np.ndarray:
        moved = state.copy()
        motion.velocity[1:-1] = z[: d * (n - 1)].reshape(-1, d)
        motion.border[:] = z[d * (n - 1) :]
        explicit.move(1.0, moved.q, moved.b, inertia, motion)
        explicit.evaluate(
            system.physics,
            system.mesh,
            state.holonomy,
            system.room,
            moved.q,
            moved.b,
            inertia,
            motion,
        )
        r, rb = system.room.r, system.room.rb
        growth = rb[1] - rb[0] + np.sum(r[1:-1, :d] * inertia.carried[1:-1])
        return np.concatenate([r[1:-1, :d].ravel(), [growth], rb[2 : 2 + d]])

    h = 1e-7
    hessian = np.array([(forces(h * z) - forces(-h * z)) / (2 * h) for z in np.eye(size)])
    assert hessian == pytest.approx(hessian.T, abs=1e-6 * abs(hessian).max())
    inverse = np.zeros((size, size))
    for i in range(n - 1):
        inverse[d * i : d * i + d, d * i : d * i + d] = inertia.inverse[i + 1]
    inverse[d * (n - 1), d * (n - 1)] = 1 / inertia.wetted[0]
    inverse[-d:, -d:] = np.diag(1 / inertia.centre)
    largest = np.linalg.eigvals(inverse @ hessian).real.max()
    assert 1 < largest < 4 / masses.SAFETY * (1 + 1e-6)


@pytest.mark.parametrize("method", ["fire", "kinetic"])
def test_says_when_it_ran_out_of_steps(pushed: tuple[System, State, State], method: str) -> None:
    system, guess, _ = pushed
    relaxer = make_relaxer(method)
    relaxer.limit = 1000
    solution = relax(relaxer, system, disturbed(guess, 1e-3))
    assert solution.outcome is Outcome.MAX_ITERATIONS
    assert solution.iterations == 1000
    system.gradient(solution.state)
    assert system.excess(solution.state, relaxer.finest)[1] == pytest.approx(
        solution.residual, rel=1e-6
    )
    assert solution.residual > relaxer.finest


@pytest.mark.parametrize("method", ["fire", "kinetic", "elliptic"])
def test_says_when_a_state_is_no_good(pushed: tuple[System, State, State], method: str) -> None:
    system, guess, _ = pushed
    outside = guess.copy()
    outside.q[system.edges // 2, 0] += 1.0  # beyond the wall
    assert relax(make_relaxer(method), system, outside).outcome is Outcome.DIVERGED
    broken = guess.copy()
    broken.q[3, 0] = np.nan
    assert relax(make_relaxer(method), system, broken).outcome is Outcome.DIVERGED
