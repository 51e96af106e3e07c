"""The softest modes of an increment."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import brentq

import derod
from derod.equilibrium.stability import lowest_mode
from derod.equilibrium.system import System
from derod.pushing.encode import decode
from derod.record import BaseRun
from derod.record.modes import ModesError


def test_as_many_are_negative_as_the_row_says(planar: BaseRun) -> None:
    counts = set()
    for i in range(0, len(planar), 5):
        unstable = planar[i].unstable_modes
        assert np.count_nonzero(planar.modes(i, 4).eigenvalues < 0) == unstable
        counts.add(unstable)
    assert counts == {0, 1}


def test_the_lowest_is_that_of_the_push(planar: BaseRun) -> None:
    system = System(planar.scene)
    state = decode(system, planar.frame_at(-1), slides=False)
    start = np.random.default_rng(1).normal(size=state.q.shape)
    value, mode, _ = lowest_mode(system, state, start)
    found = planar.modes(-1, 1)
    assert value < 0 and found.eigenvalues[0] == pytest.approx(value, rel=1e-8)
    shape, other = found.shapes[0], mode[:, :3]
    other = other / other.ravel()[np.abs(other).argmax()]
    assert min(abs(shape - other).max(), abs(shape + other).max()) < 1e-5


def test_the_energy_along_a_mode(run: BaseRun) -> None:
    """E(a) - E(0) = lambda a^2 u.M u / 2 for a displacement a u put back on the constraints."""
    system = System(run.scene)
    state = decode(system, run.frame_at(-1), slides=False)
    found = run.modes(-1, 3)
    system.gradient(state)
    energy, length = system.energies(state).total, system.rest_lengths(state)
    dual = 0.5 * (np.append(0, length) + np.append(length, 0))
    for k, value in enumerate(found.eigenvalues):
        size = np.sum(dual[1:-1, None] * found.shapes[k][1:-1] ** 2)
        size += np.sum(found.menisci[k] ** 2) + np.sum(found.drop[k] ** 2)
        rises = []
        for amplitude in (1e-3, -1e-3):
            moved = state.copy()
            moved.q[:, :3] += amplitude * found.shapes[k]
            moved.b[:2] += amplitude * found.menisci[k]
            moved.b[2:5] += amplitude * found.drop[k]
            assert system.project(moved)
            rises.append(system.energies(moved).total - energy)
        # odd terms cancel; the way back to the constraints is of second order, and costs no first
        expected = 0.5 * value * 1e-6 * size
        assert np.mean(rises) == pytest.approx(expected, rel=0.05)


def test_modes_are_orthogonal_and_leave_turning_out(run: BaseRun) -> None:
    found = run.modes(-1, 5)
    assert (np.diff(found.eigenvalues) >= 0).all() and len(found) == 5
    assert abs(found.shapes).max(axis=(1, 2)) == pytest.approx(1.0)
    assert (found.shapes[:, [0, -1]] == 0).all(), "clamps do not move"
    assert found.menisci.sum(axis=1) == pytest.approx(0, abs=1e-9), "the drop does not slide"
    length = np.diff(run.arc_length(-1))
    dual = 0.5 * (np.append(0, length) + np.append(length, 0))
    turn = np.cross([0, 0, 1.0], run.positions(-1))
    turn_drop = np.cross([0, 0, 1.0], run.drop_center(-1))

    def product(u: tuple, v: tuple) -> float:
        return float(np.sum(dual[:, None] * u[0] * v[0]) + u[1] @ v[1] + u[2] @ v[2])

    parts = [*zip(found.shapes, found.drop, found.menisci, strict=True)]
    parts.append((turn, turn_drop, np.zeros(2)))
    gram = np.array([[product(u, v) for v in parts] for u in parts])
    scale = np.sqrt(np.diag(gram))
    assert abs(gram / scale / scale[:, None] - np.eye(6)).max() < 1e-6
    assert "5 modes: eigenvalues" in repr(found)


def test_planar_rods_and_what_is_refused(run: BaseRun) -> None:
    import derod
    from tests.scenes import coil

    flat = derod.push(coil(dimension=2, stop='"0.1 pi"'))
    found = flat.modes(-1, 3)
    assert (found.shapes[:, :, 0] == 0).all() and (found.eigenvalues > 0).all()
    for k in (0, 10_000):
        with pytest.raises(ModesError, match=f"k = {k}: allowed: 1 to"):
            run.modes(-1, k)
    with pytest.raises(IndexError):
        run.modes(10_000)


def test_a_beam_under_tension_without_a_drop() -> None:
    # K y_ssss - T y_ss = lambda y between clamps: in pairs, and no rows of a drop that is not there
    tension = 10.0

    def determinant(value: float) -> float:
        root = np.sqrt(tension**2 + 4 * value)
        a, b = np.sqrt((root + tension) / 2), np.sqrt((root - tension) / 2)
        return float(
            2 * a * b * (1 / np.cosh(a) - np.cos(b)) + (a**2 - b**2) * np.tanh(a) * np.sin(b)
        )

    exact = [brentq(determinant, 500, 1000), brentq(determinant, 3000, 6000)]
    scene = derod.Scene("greenhill", {"mesh.edges": 60, "push.stop": "0.01 pi"})
    found = derod.push(scene).modes(0, 4)
    assert found.eigenvalues == pytest.approx(np.repeat(exact, 2), rel=3e-4)
    assert not found.menisci.any() and not found.drop.any()
