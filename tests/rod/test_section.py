"""Rods with two bending stiffnesses and a natural shape, against closed forms and the Kirchhoff equations."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_bvp, solve_ivp
from scipy.optimize import brentq

import derod
from derod.equilibrium.symmetry import asymmetric
from derod.equilibrium.system import System
from derod.pushing.guess import bent_guess
from derod.record.sections import edge_directors
from derod.rod import assembly
from derod.scene import Scene, build_scene
from tests.rod.states import Sample
from tests.scenes import coil

DRY: dict[str, Any] = {
    "rod": {"length": 1.0, "bending": [1.0, 3.0], "twisting": 0.7},
    "clamps": {"directors": [0.3, 2.3]},
    "push": {"stop": 0.2, "max_step": 0.05},
    "mesh": {"edges": 60},
    "model": {"drop": False},
}


def dry(changes: dict[str, Any] | None = None) -> Scene:
    return build_scene(DRY).replace(changes or {})


def straight(scene: Scene, tension: float) -> tuple[System, Any]:
    """The straight, twisted rod under a tension; its end slides, or a length would be one too many."""
    system = System(scene)
    physics = system.physics._replace(slides=True, end_tension=tension)
    state = bent_guess(system, physics, 1e-9)
    state.q[:, :2] = 0.0
    state.clamp_at(0.0)
    state.q[:, 2] = system.arc_length(state)
    state.q[1:, 3] = tension
    return system, state


@pytest.mark.parametrize("turn", [0.0, 1.0, 7.0, 20.0])
def test_twist_of_the_straight_rod_through_full_turns(turn: float) -> None:
    system, state = straight(dry({"clamps.directors": [0.3, 0.3 + turn]}), 5.0)
    assert system.gradient(state)
    energies = system.energies(state).parts
    assert energies["twist"] == pytest.approx(0.5 * 0.7 * turn**2, rel=1e-12)
    assert energies["bend"] == pytest.approx(0.0, abs=1e-20)
    assert np.abs(system.room.r[1:-1]).max() < 1e-11


def test_energy_does_not_see_a_turn_of_the_rod_with_its_clamps() -> None:
    sample, turned = Sample(3, section=True), Sample(3, section=True)
    angle = 0.7
    turn = np.array(
        [[np.cos(angle), -np.sin(angle), 0], [np.sin(angle), np.cos(angle), 0], [0, 0, 1]]
    )
    for columns in (slice(0, 3), slice(5, 8), slice(8, 11)):
        turned.q[:, columns] = sample.q[:, columns] @ turn.T
    turned.b[2:5] = turn @ sample.b[2:5]
    frames = turned.room.kin.frames
    assert frames is not None
    for directors in (frames.first, frames.second):
        for e in (0, -1):
            directors[:, e] = turn @ directors[:, e]
    values = []
    for one in (sample, turned):
        physics = one.physics._replace(weight=0.0)
        assembly.gradient(physics, one.mesh, one.q, one.b, 0.0, one.room)
        values.append(np.array(assembly.energies(physics, one.q, one.b, 0.0, one.room)))
    np.testing.assert_allclose(values[0], values[1], rtol=1e-12)


def critical_tension(scene: Scene) -> float:
    """The largest tension at which the straight rod is not stable, by the discrete rod's count."""

    def unstable(tension: float) -> bool:
        system, state = straight(scene, tension)
        return system.linearise(state) > 0

    low, high = -100.0, 60.0
    assert unstable(low) and not unstable(high)
    for _ in range(40):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if unstable(middle) else (low, middle)
    return 0.5 * (low + high)


def greenhill(scene: Scene) -> float:
    """The same of the continuous rod: the second variation's equation, clamped at both ends.

    int w''.B w''/2 + T |w'|^2/2 + (M/2) w''.J w' ds, with B turning with the section and M = K3 u3.
    """
    rod, (start, end) = scene.rod, scene.clamps.directors or (0.0, 0.0)
    k1, k2, rate = rod.bending, rod.bending_2 or rod.bending, (end - start) / rod.length
    half = 0.5 * rod.twisting * rate * np.array([[0.0, 1.0], [-1.0, 0.0]])

    def determinant(tension: float) -> float:
        def slope(s: float, y: np.ndarray) -> np.ndarray:
            angle = start + rate * s
            d1, d2 = (
                np.array([np.cos(angle), np.sin(angle)]),
                np.array([-np.sin(angle), np.cos(angle)]),
            )
            soft = np.outer(d1, d1) / k2 + np.outer(d2, d2) / k1
            a, m, n = y[2:4], y[4:6], y[6:8]
            bent = soft @ (m - half @ a)
            return np.concatenate([a, bent, tension * a + half.T @ bent - n, 0 * n])

        ends = []
        for k in range(4):
            y = np.zeros(8)
            y[4 + k] = 1.0
            out = solve_ivp(slope, (0, rod.length), y, rtol=1e-11, atol=1e-13, method="DOP853")
            ends.append(out.y[:4, -1])
        return float(np.linalg.det(np.array(ends)))

    grid = np.linspace(60.0, -100.0, 81)
    values = [determinant(t) for t in grid]
    first = next(i for i in range(80) if values[i] * values[i + 1] < 0)
    return float(brentq(determinant, grid[first + 1], grid[first], xtol=1e-10))


@pytest.mark.parametrize("turn", [0.0, 4.0, 9.0])
def test_buckling_of_a_twisted_strip(turn: float) -> None:
    """Greenhill's problem for K1 != K2; clamped ends, whose cells make it converge with order 3 to 4."""
    errors = []
    for edges in (40, 80):
        scene = dry({"clamps.directors": [0.3, 0.3 + turn], "mesh.edges": edges})
        errors.append(abs(critical_tension(scene) - greenhill(scene)))
    assert errors[1] < 5e-3
    assert errors[1] < errors[0] / 6


def kirchhoff(scene: Scene, run: Any) -> tuple[float, float]:
    """End tension and m_3 at s = l of the clamped rod: scipy's collocation of sys:kirchhoff-equilibrium."""
    rod = scene.rod
    (start, end), length = scene.clamps.directors or (0.0, 0.0), rod.length
    stiffness = np.array([rod.bending, rod.bending_2 or rod.bending, rod.twisting])
    natural = np.array([*(rod.natural_curvature or (0, 0)), rod.natural_twist or 0.0])
    positions, s = run.positions(-1), run.arc_length(-1)

    def frames(y: np.ndarray) -> list[np.ndarray]:
        return [y[3 + 3 * k : 6 + 3 * k] for k in range(3)]

    def slope(_: np.ndarray, y: np.ndarray) -> np.ndarray:
        d, n, m = frames(y), y[12:15], y[15:18]
        u = m / stiffness[:, None] + natural[:, None]
        space = sum(u[k] * d[k] for k in range(3))
        axes = [np.cross(space, d[k], axis=0) for k in range(3)]
        force = np.cross(d[2], n, axis=0)  # m' = -d_3 x n in space
        about = np.array([-np.sum(force * d[k], axis=0) for k in range(3)])
        return np.concatenate([d[2], *axes, 0 * n, about - np.cross(u, m, axis=0)])

    def ends(a: np.ndarray, b: np.ndarray) -> np.ndarray:
        cosine, sine = math.cos(end), math.sin(end)
        begin = np.array(
            [math.cos(start), math.sin(start), 0, -math.sin(start), math.cos(start), 0, 0, 0, 1]
        )
        return np.concatenate(
            [a[:3], a[3:12] - begin, b[:3] - positions[-1],
             [b[9], b[10], b[3] * -sine + b[4] * cosine]]
        )  # fmt: skip

    at = np.concatenate([[0.0], 0.5 * (s[1:] + s[:-1]), [length]])
    directors = edge_directors(positions, run.edge_frame(-1), scene)
    guess = np.zeros((18, at.size))
    guess[:3] = [np.interp(at, s, positions[:, k]) for k in range(3)]
    guess[3:12] = directors.reshape(-1, 9).T
    space = np.array([np.interp(at, s, run.moment(-1)[:, k]) for k in range(3)])
    guess[15:18] = np.einsum("nik,kn->in", directors, space)
    guess[14] = run.table["end_tension"][-1]
    found = solve_bvp(slope, ends, at, guess, tol=1e-7, max_nodes=20000)
    assert found.success, found.message
    return float(found.y[14, -1]), float(found.y[17, -1])


@pytest.mark.parametrize(
    "shape",
    [{}, {"rod.natural_curvature": [1.5, -0.7], "rod.natural_twist": 0.8}],
    ids=["straight", "curled"],
)
def test_a_buckled_strip_against_the_kirchhoff_equations(shape: dict[str, Any]) -> None:
    errors = []
    for edges in (40, 80):
        run = derod.push(dry({**shape, "mesh.edges": edges}))
        assert run.outcome == "completed" and run.table["unstable_modes"][-1] == 0
        tension, _ = kirchhoff(run.scene, run)
        errors.append(abs(float(run.table["end_tension"][-1]) - tension) / abs(tension))
    assert errors[1] < 2e-5
    assert errors[1] < errors[0] / 5


def test_equal_stiffnesses_are_a_round_rod() -> None:
    scene = coil(edges=40, stop='"0.3 pi"')
    one, two = derod.push(scene), derod.push(scene.replace({"rod.bending": [1, 1]}))
    for name in ("end_tension", "energy_hat", "energy_twist"):
        assert np.array_equal(one.table[name], two.table[name])
    nearly = derod.push(scene.replace({"rod.bending": [1, 1 + 1e-6], "clamps.directors": [0, 0]}))
    for name in ("end_tension", "energy_hat"):
        assert nearly.table[name][-1] == pytest.approx(one.table[name][-1], rel=2e-5)


def test_a_strip_coils_out_of_its_plane_as_its_branches_do() -> None:
    """K2/K1 = 4, v0 = 2e-2: t and E_hat of 3D at 0.6 pi by derod.branches (runs/two_stiffnesses.py)."""
    scene = coil(edges=100, stop='"0.6 pi"', wall=2e-2).replace(
        {"rod.bending": [1, 4], "clamps.directors": [0, 0]}
    )
    run = derod.push(scene)
    last = run.table[-1]
    assert [event.kind for event in run.events].count("instability") == 1
    assert last["end_tension"] == pytest.approx(21.55253848, rel=2e-5)
    assert last["energy_hat"] == pytest.approx(12.13900381, rel=5e-5)
    smooth = run.table["smooth"]
    assert np.abs(run.table["work_defect"][smooth]).max() < 1e-4 * last["energy_hat"]


def test_a_strip_is_recorded_and_resumed(tmp_path: Path) -> None:
    scene = coil(edges=30, stop='"0.6 pi"').replace(
        {"rod.bending": [1, 4], "clamps.directors": [0, 0]}
    )
    whole, cut = tmp_path / "whole.h5", tmp_path / "cut.h5"
    with derod.push(scene, whole) as run:
        assert run.verify() == len(run)
        frame = run.directors(-1)
        for one, other in ((frame.d1, frame.d2), (frame.d2, frame.d3), (frame.d3, frame.d1)):
            assert np.abs(np.sum(one * other, axis=1)).max() < 1e-12
        np.testing.assert_allclose(frame.d1[[0, -1]], [[1, 0, 0]] * 2, atol=1e-12)
        expected = [run.frame_at(i) for i in range(len(run))]
    short = scene.replace({"push.stop": "0.52 pi"})
    derod.push(short, cut).close()
    with derod.push(scene, resume=cut) as run:
        matched = 0
        for i in range(len(run)):
            frame, other = run.frame_at(i), expected[min(i, len(expected) - 1)]
            if frame.row["end_shortening"] == other.row["end_shortening"]:
                assert frame.edge_frame is not None and other.edge_frame is not None
                np.testing.assert_allclose(frame.positions, other.positions, atol=1e-7)
                matched += 1
        assert matched > 20


def test_modes_of_a_strip_are_those_that_are_counted() -> None:
    """Ax at 0.5 pi, stable at K2/K1 = 16; the branches' pitchfork is at 0.537 pi."""
    scene = coil(edges=40, stop='"0.5 pi"', wall=2e-2).replace(
        {"rod.bending": [1, 16], "clamps.directors": [0, 0]}
    )
    run = derod.push(scene)
    assert run.table["unstable_modes"][-1] == 0 and run.table["energy_twist"][-1] == 0
    stable = run.modes(-1, 3)
    assert stable.eigenvalues[0] > 0 and np.all(np.diff(stable.eigenvalues) >= 0)
    earlier = run.modes(len(run) - 8, 1)
    assert earlier.eigenvalues[0] > stable.eigenvalues[0], "it softens toward its pitchfork"
    with pytest.raises(ValueError, match="round sections"):
        run.sensitivities(-1)


@pytest.mark.parametrize(
    ("directors", "kept"),
    [
        ([0, 0], True),
        ([0, "pi"], True),
        (["pi/2", "pi/2"], True),
        ([0, "pi/2"], False),
        ([0.3, 0.3], False),
    ],
)
def test_a_centre_line_keeps_its_symmetries_only_where_the_section_does(
    directors: list[Any], kept: bool
) -> None:
    assert asymmetric(System(dry({"clamps.directors": directors})).physics) is not kept
    curled = dry({"clamps.directors": directors, "rod.natural_curvature": [1, 0]})
    assert asymmetric(System(curled).physics)
