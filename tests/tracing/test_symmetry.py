"""Duplicates are recognised under every symmetry, and nothing else is."""

from __future__ import annotations

import numpy as np
import pytest

from derod.rod.state import State
from derod.rod.unknowns import S_A, S_B, X_C
from derod.tracing.symmetry import SAME, character, distance, node_weights
from tests.tracing.paths import planar, side


def turned(state: State, angle: float) -> State:
    out = state.copy()
    c, s = np.cos(angle), np.sin(angle)
    for array, start in ((out.q, 0), (out.b[None, :], X_C)):
        x, y = array[:, start].copy(), array[:, start + 1].copy()
        array[:, start], array[:, start + 1] = c * x - s * y, s * x + c * y
    return out


def mirrored(state: State) -> State:
    out = state.copy()
    out.q[:, 0] *= -1
    out.b[X_C] *= -1
    out.holonomy *= -1
    return out


def flipped(state: State) -> State:
    """Run from the other end, after a half turn about the line along x across the axis's middle."""
    out = state.copy()
    end, length = state.q[-1, 2], state.physics.length
    out.q[:, :3] = state.q[::-1, :3] * (1, -1, -1)
    out.q[:, 2] += end
    out.q[1:, 3] = state.q[1:, 3][::-1]
    out.b[X_C : X_C + 3] = state.b[X_C : X_C + 3] * (1, -1, -1)
    out.b[X_C + 2] += end
    out.b[S_A], out.b[S_B] = length - state.b[S_B], length - state.b[S_A]
    f = X_C + 3
    out.b[f], out.b[f + 1] = state.b[f + 1], state.b[f]
    return out


IMAGES = {
    "itself": lambda state: state,
    "turn": lambda state: turned(state, 1.234),
    "mirror": mirrored,
    "flip": flipped,
    "all": lambda state: turned(flipped(mirrored(state)), -2.1),
}


@pytest.mark.parametrize("name", IMAGES)
@pytest.mark.parametrize("index", [0, 1])
def test_images_are_one_state(name: str, index: int) -> None:
    """They are equilibria of equal energy, and no distance apart."""
    system = planar()[0].system
    state = side(index).points[20].state
    image = IMAGES[name](state)
    assert system.gradient(image)
    assert system.excess(image, 1e-6)[0] <= 1
    assert system.energies(image).total == pytest.approx(system.energies(state).total, rel=1e-9)
    weight = node_weights(system.rest_lengths(state))
    assert distance(image, state, weight) < SAME
    assert distance(state, image, weight) < SAME


def test_different_states_are_apart() -> None:
    system = planar()[0].system
    points = side(1).points
    weight = node_weights(system.rest_lengths(points[20].state))
    assert distance(points[20].state, points[21].state, weight) > 10 * SAME


def test_the_character_of_paths() -> None:
    system = planar()[0].system

    def of(state: State) -> str:
        return character(state, node_weights(system.rest_lengths(state)))

    assert of(planar()[1].points[20].state) == "planar, flip-even"
    assert of(side(0).points[20].state) == "spatial, flip-even"
    assert of(side(1).points[20].state) == "spatial, asymmetric"
