"""Going down: no accepted step raises the energy on the constraints; saddles are left as they are seen."""

from __future__ import annotations

import numpy as np
import pytest

import derod
from derod.equilibrium.loop import Outcome, Report, relax
from derod.equilibrium.measured import measure
from derod.equilibrium.methods import make_relaxer
from derod.equilibrium.system import System
from derod.pushing.controls import CONTROLS
from derod.pushing.descent import Descender, Descent, Noise
from derod.pushing.driver import frame_of
from derod.pushing.encode import decode
from derod.pushing.kicks import breaks_a_symmetry, kick
from derod.rod.state import State
from derod.scene import Scene
from tests.scenes import coil

ROUNDING = 1e-10  # of energies near 200


def pushed(scene: Scene) -> tuple[System, State]:
    """The last state of a push."""
    run = derod.push(scene)
    assert run.ending is not None and run.ending.outcome == "completed", run.ending
    system = System(scene)
    return system, decode(system, frame_of(run, len(run) - 1))


def disturbed(system: System, state: State, size: float, seed: int) -> State:
    """A state moved by smooth waves with random amplitudes, in all its directions."""
    rng = np.random.default_rng(seed)
    d, n = state.dimension, system.edges
    place = np.linspace(0, np.pi, n + 1)[1:-1]
    gap = system.wall_gap(state)
    for _ in range(60):
        moved = state.copy()
        for wave in range(1, 9):
            moved.q[1:-1, :d] += size / wave * np.outer(np.sin(wave * place), rng.normal(size=d))
        moved.b[2 : 2 + d] += 0.1 * size * rng.normal(size=d)
        if system.wall_gap(moved) > 0.3 * gap:
            return moved
        size *= 0.7
    raise AssertionError("no room to disturb the state")


def energies_on_the_way(system: System, start: State) -> tuple[list[float], list[float], Outcome]:
    """E_tot and the largest violation of a length, after every accepted step."""
    energies: list[float] = []
    violations: list[float] = []

    def watch(_: int, state: State, report: Report) -> None:
        energies.append(system.energies(state).total)
        lengths = np.abs(system.room.r[1:, state.dimension]) / system.room.kin.rest[1:-1]
        violations.append(float(lengths.max()))

    solution = relax(make_relaxer("implicit"), system, start, descend=True, watch=watch)
    return energies, violations, solution.outcome


@pytest.mark.parametrize("edges", [24, 60])
@pytest.mark.parametrize("dimension", [2, 3])
def test_no_step_goes_uphill(edges: int, dimension: int) -> None:
    """Past the pitchfork too, on a coarse mesh, where a residual that falls need not mean descent."""
    system, state = pushed(coil(edges=edges, dimension=dimension, noise=0.0))
    steps = 0
    for seed in range(14):
        start = disturbed(system, state, 0.04 if seed % 2 else 0.1, seed)
        energies, violations, outcome = energies_on_the_way(system, start)
        assert outcome is Outcome.CONVERGED, outcome
        assert np.diff(energies).max() < ROUNDING * (1 + abs(energies[0])), (seed, energies)
        assert max(violations) < 1e-8
        steps += len(energies) - 1
    assert steps > 14 * 5, "the starts were no trial"


def test_a_descent_from_a_wrong_length_is_put_onto_its_constraints_first() -> None:
    system, start = pushed(coil(edges=40, stop='"0.1 pi"'))
    start.q[1:-1, 1] *= 0.75
    energies, violations, outcome = energies_on_the_way(system, start)
    assert outcome is Outcome.CONVERGED
    assert violations[0] < 1e-8
    assert np.diff(energies).max() < ROUNDING * (1 + abs(energies[0]))


def test_newton_stays_where_the_branch_was_predicted() -> None:
    """Without descent, an equilibrium farther than a prediction may be off is not taken."""
    system, far = pushed(coil(edges=60, stop='"0.05 pi"'))
    far.clamp_at(0.15 * np.pi)
    solution = relax(make_relaxer("implicit"), system, far)
    assert not solution.converged
    _, near = pushed(coil(edges=60, stop='"0.15 pi"'))
    assert np.abs(near.q[:, :3] - far.q[:, :3]).max() > 0.1


def unstable_planar() -> tuple[System, State]:
    """The planar rod past its pitchfork, in space: without noise it stays there."""
    system, state = pushed(coil(edges=60, noise=0.0))
    assert measure(system, state, CONTROLS["end_shortening"]).unstable_modes == 1
    return system, state


def descent_with_noise(system: System, start: State, seed: int) -> Descent:
    relaxer = make_relaxer("implicit")

    def down(state: State):
        return relax(relaxer, system, state, descend=True, kick=1e-3)

    return Descender(
        system, down, lambda s: measure(system, s, CONTROLS["end_shortening"]), Noise(seed, 0, 1e-3)
    ).descend(start)


def test_a_saddle_is_left_as_soon_as_it_is_seen() -> None:
    """A planar descent toward a planar saddle does not go there: it is kicked out of its plane."""
    system, state = unstable_planar()
    start = state.copy()
    start.q[1:-1, 1] += 0.02 * np.sin(np.linspace(0, np.pi, system.edges + 1))[1:-1]
    saddle = system.energies(state).total
    ends = [descent_with_noise(system, start, seed) for seed in range(3)]
    for descent in ends:
        assert descent.stable and descent.here is not None
        assert len(descent.kicks) == 1 and descent.kicks[0].mirror
        assert "mirror images" in descent.sides()
        assert descent.here.energy < saddle - 1e-2
        assert descent.iterations < 200, "the saddle was approached for long"
    assert np.ptp([d.here.energy for d in ends if d.here]) < 1e-9
    # without noise it goes to the saddle itself, by Newton's steps
    solution = relax(make_relaxer("implicit"), system, start, descend=True)
    assert solution.converged and solution.iterations < 200
    assert system.energies(solution.state).total == pytest.approx(saddle, abs=1e-9)


def test_a_kick_goes_down_on_both_sides_and_knows_the_mirror() -> None:
    system, state = unstable_planar()
    vector = np.random.default_rng(3).standard_normal(state.q.shape)
    energy = system.energies(state).total
    kicks = [kick(system, state, 1e-2, vector, side) for side in (1.0, -1.0)]
    for one in kicks:
        assert not one.sloped and one.mirror and one.eigenvalue < 0
        assert system.energies(one.state).total < energy
    np.testing.assert_allclose(kicks[0].state.q[:, 0], -kicks[1].state.q[:, 0], atol=1e-9)
    assert np.abs(kicks[0].state.q[:, 0]).max() == pytest.approx(1e-2, rel=1e-2)
    # an in-plane move of a planar state breaks no mirror at that plane; a twisted rod has none
    mode = np.zeros_like(state.q)
    mode[:, 1] = np.sin(np.linspace(0, np.pi, system.edges + 1))
    assert not breaks_a_symmetry(state, mode, twist=0.0)
    out = np.zeros_like(state.q)
    out[:, 0] = np.sin(np.linspace(0, np.pi, system.edges + 1)) + 0.3 * np.linspace(
        0, 1, out.shape[0]
    )
    assert breaks_a_symmetry(state, out, twist=0.0)
    assert not breaks_a_symmetry(state, out, twist=0.5)
