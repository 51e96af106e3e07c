"""Derivatives by every parameter against central differences of re-settled states."""

from __future__ import annotations

import numpy as np
import pytest

import derod
from derod.equilibrium.eigen import turns_freely
from derod.equilibrium.loop import relax
from derod.equilibrium.methods import make_relaxer
from derod.equilibrium.sensitivity import Sensitivity, parameters_of, sensitivities
from derod.equilibrium.system import System
from derod.pushing.controls import CONTROLS
from derod.record.modes import state_of
from derod.rod.state import State
from derod.rod.unknowns import X_C
from derod.scene import Scene
from tests.scenes import coil

STEP = 2e-4  # of a parameter
CLOSE = 1e-6
SMALL = {"wall_strength": 0.01, "wall_softness": 1e-5, "end_rotation": 5e-4, "length": 1e-3}
"""Steps of what enters strongly, or has no size of its own."""


def random_scene(seed: int) -> Scene:
    """A coil in space: any end rotation, capillarity, wall, twisting and stiffness."""
    rng = np.random.default_rng([164, seed])
    return coil(
        edges=40,
        stop=f'"{rng.uniform(0.1, 0.6):.4f} pi"',
        wall=float(10 ** rng.uniform(-3.5, -1.5)),
        rotation=float(rng.uniform(-1.0, 1.0)),
    ).replace(
        {
            "rod.bending": float(rng.uniform(0.7, 1.5)),
            "rod.twisting": float(rng.uniform(0.6, 1.4)),
            "rod.length": float(rng.uniform(7.0, 10.0)),
            "drop.capillary_force": float(rng.uniform(15.0, 25.0)),
        }
    )


def sharpened(system: System, state: State, tolerance: float = 1e-13) -> State:
    """The equilibrium near a state, to rounding."""
    solution = relax(make_relaxer("implicit"), system, state, tolerance)
    assert solution.converged, solution.message
    return solution.state


def observed(system: System, state: State) -> dict[str, np.ndarray]:
    """What is derived, at a settled state."""
    system.gradient(state)
    physics = state.physics
    energy = system.energies(state).total
    moment = physics.twisting * (physics.end_rotation - state.holonomy) / physics.length
    return {
        "tension": np.array(physics.end_tension if physics.slides else system.end_tension(state)),
        "energy_hat": np.array(energy + physics.capillary_force * (state.end_shortening + 1)),
        "end_shortening": np.array(state.end_shortening),
        "twisting_moment": np.array(moment if state.dimension == 3 else 0.0),
        "q": state.q.copy(),
        "b": state.b.copy(),
        "arc_length": np.concatenate([[0.0], np.cumsum(system.room.kin.rest[1:-1])]),
    }


def changed(state: State, name: str, by: float) -> State:
    """The state with another value of a parameter, not settled."""
    out = state.copy()
    if name == "end_shortening":
        out.clamp_at(state.end_shortening + by)
        return out
    out.physics = state.physics._replace(**{name: getattr(state.physics, name) + by})
    if name == "length" and not state.physics.slides:
        out.clamp_at(state.end_shortening)
    return out


def differences(scene: Scene, state: State, name: str) -> dict[str, np.ndarray]:
    """Derivatives by five-point differences of re-settled states."""
    value = abs(getattr(state.physics, name, 1.0)) if name != "end_shortening" else 1.0
    step = SMALL.get(name, STEP) * (value if name != "end_rotation" and value > 0 else 1.0)
    near = []
    for times in (-2, -1, 1, 2):
        system = System(scene)
        settled = sharpened(system, changed(state, name, times * step))
        near.append(observed(system, settled))
    return {
        key: (8 * (near[2][key] - near[1][key]) - (near[3][key] - near[0][key])) / (12 * step)
        for key in near[0]
    }


def unturned(
    wanted: dict[str, np.ndarray], mine: Sensitivity, state: State
) -> dict[str, np.ndarray]:
    """Differences turned about the axis to fit best: settled states may differ by a turn that is free."""
    if not turns_freely(state):
        return wanted
    turn = {"q": np.zeros_like(state.q), "b": np.zeros_like(state.b)}
    turn["q"][:, 0], turn["q"][:, 1] = -state.q[:, 1], state.q[:, 0]
    turn["b"][X_C], turn["b"][X_C + 1] = -state.b[X_C + 1], state.b[X_C]
    amount = np.sum((mine.q - wanted["q"]) * turn["q"]) / np.sum(turn["q"] ** 2)
    return wanted | {key: wanted[key] + amount * turn[key] for key in turn}


def check(
    scene: Scene, run: derod.BaseRun, names: tuple[str, ...] | None = None, i: int = -1
) -> None:
    """Hold every derivative at a run's state against differences."""
    system, state = state_of(run, i)
    state = sharpened(system, state)
    here, found = sensitivities(system, state, CONTROLS)
    assert tuple(found) == parameters_of(state)
    assert here.unstable_modes == 0
    for name in names or found:
        wanted = unturned(differences(scene, state, name), found[name], state)
        for key, exact in wanted.items():
            mine = np.asarray(getattr(found[name], key))
            scale = np.abs(exact).max()
            floor = 1e-9 if key in ("tension", "energy_hat", "twisting_moment") else 1e-8
            assert np.abs(mine - exact).max() <= CLOSE * scale + floor * others(key, found), (
                name, key, mine if mine.ndim == 0 else None, exact if exact.ndim == 0 else None,
            )  # fmt: skip


def others(key: str, found: dict[str, Sensitivity]) -> float:
    """How large derivatives of this quantity are by the end's place: zeros are held to that."""
    first = next(iter(found.values()))
    return float(np.abs(getattr(first, key)).max()) or 1.0


@pytest.mark.parametrize("seed", range(4))
def test_random_scenes(seed: int) -> None:
    scene = random_scene(seed)
    run = derod.push(scene)
    names = parameters_of(state_of(run, -1)[1])
    # a weight turns a coil that had none about the axis
    check(scene, run, tuple(name for name in names if name != "weight"))


def test_a_heavy_drop() -> None:
    scene = random_scene(5).replace({"drop.weight": 1.5})
    check(scene, derod.push(scene))


def test_in_the_plane() -> None:
    scene = coil(edges=40, stop='"0.3 pi"', dimension=2)
    check(scene, derod.push(scene))


def test_without_a_drop() -> None:
    scene = derod.Scene(
        rod={"length": 3.0, "bending": 1.0, "twisting": 0.8},
        clamps={"end_rotation": 2.0},
        push={"start": 0.05, "stop": 0.7, "at": []},
        mesh={"edges": 40},
        model={"drop": False},
    )
    check(scene, derod.push(scene))


def test_under_a_dead_load() -> None:
    scene = derod.Scene("end-tension", {"mesh.edges": 40})
    run = derod.push(scene)
    i = int(np.flatnonzero(run.table["end_tension"] == 18.5)[-1])
    state = state_of(run, i)[1]
    assert state.physics.slides
    check(scene, run, tuple(name for name in parameters_of(state) if name != "weight"), i)
