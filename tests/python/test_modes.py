"""The softest modes of an increment."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import brentq

import derod
from derod.equilibrium.eigen import Metric, turning
from derod.equilibrium.stability import lowest_mode
from derod.equilibrium.system import System
from derod.pushing.encode import decode
from derod.record import BaseRun
from derod.record.modes import Modes, ModesError, state_of
from derod.rod.unknowns import S_A, X_C
from tests.scenes import coil


def material(metric: Metric, found: Modes, k: int) -> np.ndarray:
    """What mode k moves, weighed: its square sum is z.M z, the norm of the rod's material and the drop."""
    border = np.zeros(10)
    border[S_A : S_A + 2], border[X_C : X_C + 3] = found.menisci[k], found.drop[k]
    return metric.down(found.shapes[k][1:], border)


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
    """E(a) - E(0) = lambda a^2 z.M z / 2 for a displacement a z put back on the constraints."""
    system = System(run.scene)
    state = decode(system, run.frame_at(-1), slides=False)
    found = run.modes(-1, 3)
    system.gradient(state)
    energy = system.energies(state).total
    metric = Metric(system, state)
    for k, value in enumerate(found.eigenvalues):
        size = np.sum(material(metric, found, k) ** 2)
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
    system, state = state_of(run, -1)
    system.gradient(state)
    metric = Metric(system, state)
    parts = [material(metric, found, k) for k in range(5)]
    parts.append(metric.down(*turning(state, system.factor.rhs_border.size)))
    gram = np.array(parts) @ np.array(parts).T
    scale = np.sqrt(np.diag(gram))
    assert abs(gram / scale / scale[:, None] - np.eye(6)).max() < 1e-6
    assert "5 modes: eigenvalues" in repr(found)


def test_planar_rods_and_what_is_refused(run: BaseRun) -> None:
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


def test_modes_are_even_or_odd(planar: BaseRun, run: BaseRun) -> None:
    """Ax leaves its plane flip-even, and every mode of a planar, flip-symmetric coil is one of four kinds."""
    found = planar.modes(-1, 6)
    assert found.flip[0] == "even" and found.plane[0] == "out"
    assert set(found.plane) == {"in", "out"} and set(found.flip) == {"even", "odd"}
    for shape, flip, plane in zip(found.shapes, found.flip, found.plane, strict=True):
        inside, outside = abs(shape[:, 1:]).max(), abs(shape[:, 0]).max()
        assert (outside < 1e-6 * inside) if plane == "in" else (inside < 1e-6 * outside)
        image = shape[::-1] * [-1, 1, -1]  # turned by pi about y, the direction of the coil
        sign = 1 if flip == "even" else -1
        assert abs(image - sign * shape).max() < 1e-6
    twisted = run.modes(-1, 4)
    assert set(twisted.plane) == {""} and set(twisted.flip) <= {"even", "odd"}


def test_pairs_of_a_straight_rod_are_sorted_by_their_symmetry() -> None:
    found = derod.push(derod.Scene("greenhill", {"mesh.edges": 60, "push.stop": "0.01 pi"}))
    modes = found.modes(0, 4)
    assert modes.plane == ("in", "out", "in", "out") and modes.flip == (
        "even",
        "odd",
        "odd",
        "even",
    )
    assert modes.turns_freely and modes.sliding_stiffness == np.inf


def test_a_heavy_drop_is_not_free_to_turn() -> None:
    """Rolling about the axis is a mode like any other, and the softest one."""
    heavy = derod.push(coil(edges=60, stop='"0.3 pi"').replace({"drop.weight": 2.0}))
    found = heavy.modes(-1, 1)
    assert not found.turns_freely and 0 < found.eigenvalues[0] < 1
    turn = np.cross([0, 0, 1.0], heavy.positions(-1))
    shape = found.shapes[0]
    assert np.sum(turn * shape) ** 2 > 0.9 * np.sum(turn**2) * np.sum(shape**2)


def test_a_kick_leads_off_a_saddle_or_back(planar: BaseRun, run: BaseRun) -> None:
    out = planar.kick(-1, 0, 0.02)
    assert out.converged and not out.came_back and out.moved > 0.05
    assert out.energy_after < out.energy_kicked < out.energy_before
    assert out.frame.row["unstable_modes"] == 0 and planar.table["unstable_modes"][-1] == 1
    mirrored = planar.kick(-1, 0, -0.02)
    assert mirrored.energy_after == pytest.approx(out.energy_after, rel=1e-9)
    assert np.sign(mirrored.frame.row["holonomy"]) == -np.sign(out.frame.row["holonomy"])
    back = run.kick(-1, 1, 0.02)
    assert back.came_back and back.energy_kicked > back.energy_before
    assert back.energy_after == pytest.approx(back.energy_before, rel=1e-12)
    far = run.kick(-1, 0, 5.0)
    assert abs(far.amplitude) < 5.0, "the wall is nearer"
    with pytest.raises(ModesError, match="mode = 3: allowed: 0 to 0"):
        run.kick(-1, 3, 0.1, run.modes(-1, 1))
    with pytest.raises(ModesError, match="amplitude = 0: allowed"):
        run.kick(-1, 0, 0.0)
