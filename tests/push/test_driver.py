"""The push: what it lands on, what it does at a pitchfork, how it goes on and how it ends."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import derod
from derod.errors import SceneError
from derod.pushing.frames import Outcome
from derod.pushing.stride import Stride
from derod.record import BaseRun
from tests.scenes import coil

PITCHFORK = 0.24305 * np.pi  # of Ax, paper-text (DESIGN: found by two independent solvers)


@pytest.fixture(scope="module")
def run() -> BaseRun:
    return derod.push(coil(stop='"0.4 pi"', at='["0.1 pi", "0.25 pi"]'))


def test_it_completes_with_stable_converged_rows(run: BaseRun) -> None:
    assert run.ending is not None and run.ending.outcome is Outcome.COMPLETED
    assert run.table["converged"].all()
    assert (run.table["unstable_modes"] == 0).all()
    assert run.table["end_shortening"][-1] == 0.4 * np.pi
    assert (np.diff(run.table["end_shortening"]) > 0).all()


def test_it_lands_exactly(run: BaseRun) -> None:
    landed = run.table["end_shortening"][run.table["landing"]]
    assert set(landed) == {0.001 * np.pi, 0.1 * np.pi, 0.25 * np.pi, 0.4 * np.pi}


def test_it_leaves_the_plane_at_the_pitchfork(run: BaseRun) -> None:
    flat = np.array([np.linalg.svd(run.positions(i)[:, :2])[1][1] for i in range(len(run))])
    first = np.argmax(flat > 1e-9)
    assert (flat[:first] < 1e-12).all(), "planar until it is not"
    before, after = run.table["end_shortening"][[first - 1, first]]
    assert before < PITCHFORK * 1.01
    assert after > PITCHFORK * 0.99
    assert after - before < 0.0201 * np.pi
    (event,) = [event for event in run.events if event.kind == "instability"]
    assert event.increment == first
    assert event.energy_after < event.energy_before


def test_tension_is_the_slope_of_the_energy(run: BaseRun) -> None:
    """dE_hat/ddelta = f_gamma - t, with a cubic through the rows' slopes."""
    table = run.table[run.table["end_shortening"] < 0.23 * np.pi]
    slope = 20 - table["end_tension"]
    delta, energy = table["end_shortening"], table["energy_hat"]
    step = np.diff(delta)
    work = 0.5 * step * (slope[1:] + slope[:-1])  # the trapezoid's error is step^3 slope''/12
    curve = np.abs(np.diff(slope, 2)).max() / np.min(step[1:] * step[:-1])
    assert np.abs(np.diff(energy) - work).max() < curve * step.max() ** 3 / 12
    assert np.sum(work) == pytest.approx(energy[-1] - energy[0], rel=2e-3)


def test_forces_balance_at_the_menisci(run: BaseRun) -> None:
    """f_A and f_B pull alike, and their share along the rod is the tension jump f_gamma - v."""
    table = run.table
    np.testing.assert_allclose(table["force_a"], table["force_b"], rtol=1e-6)
    assert np.abs(table["slide_force"]).max() < 1e-6
    i = len(run) - 1
    arc, tension = run.arc_length(i), run.edge_tension(i)
    node = int(np.argmin(np.abs(arc - table["meniscus_b"][i])))
    jump = tension[node] - tension[node - 1]
    assert jump == pytest.approx(20 - 2e-4 / 0.1, rel=0.02)


def test_without_noise_a_symmetric_rod_stays_planar() -> None:
    run = derod.push(coil(stop='"0.3 pi"', noise=0.0))
    assert run.ending is not None and run.ending.outcome is Outcome.COMPLETED
    beyond = run.table["end_shortening"] > 1.02 * PITCHFORK
    assert (run.table["unstable_modes"][beyond] == 1).all()
    assert (run.table["unstable_modes"][run.table["end_shortening"] < 0.98 * PITCHFORK] == 0).all()
    assert np.abs(run.positions(-1)[:, 0]).max() == 0.0


def test_a_planar_scene_follows_the_same_planar_rod() -> None:
    plane = derod.push(coil(stop='"0.2 pi"', dimension=2))
    space = derod.push(coil(stop='"0.2 pi"'))
    for name in ("end_shortening", "end_tension", "energy_hat", "wetted_length"):
        np.testing.assert_allclose(plane.table[name], space.table[name], rtol=1e-7)


def test_push_and_pull_back_end_where_they_began() -> None:
    run = derod.push(coil(stop='["0.15 pi", "0.05 pi"]', at='["0.05 pi"]'))
    first, last = np.flatnonzero(run.table["end_shortening"] == 0.05 * np.pi)
    assert run.table["segment"][first] == 0 and run.table["segment"][last] == 1
    for name in ("end_tension", "energy_hat"):
        assert run.table[name][first] == pytest.approx(run.table[name][last], rel=1e-8)


def test_the_same_seed_gives_the_same_numbers(run: BaseRun) -> None:
    again = derod.push(coil(stop='"0.4 pi"', at='["0.1 pi", "0.25 pi"]'))
    for name in run.table.dtype.names:
        if name != "wall_time":
            np.testing.assert_array_equal(again.table[name], run.table[name])


class Stopper:
    """An observer that interrupts the push after a frame beyond ``cut``."""

    def __init__(self, cut: float) -> None:
        self.cut = cut

    def start(self, *_: object) -> None: ...
    def event(self, *_: object) -> None: ...
    def finish(self, *_: object) -> None: ...
    def frame(self, frame: object) -> None:
        if frame.row["end_shortening"] > self.cut:
            raise KeyboardInterrupt


@pytest.mark.parametrize(
    ("start", "cut"), [("0.001 pi", 0.2), ("0.001 pi", 0.31), ("0.3 pi", 0.33), ("0.3 pi", 0.0)]
)
def test_resumed_bit_for_bit(tmp_path: Path, start: str, cut: float) -> None:
    """A run cut off after some frames, then resumed, gives the table of one that never stopped.

    One that starts at 0.3 pi is led in from nearly nothing, unrecorded; cut at its first row, too.
    """
    path = tmp_path / "run.h5"
    scene = coil(stop='"0.4 pi"').replace({"push.start": start})
    whole = derod.push(scene)
    interrupted = derod.push(scene, path, [Stopper(cut * np.pi)])
    assert interrupted.ending is not None
    assert interrupted.ending.outcome is Outcome.INTERRUPTED
    assert len(interrupted) < len(whole)
    interrupted.close()
    resumed = derod.push(None, resume=path)
    for name in whole.table.dtype.names:
        if name != "wall_time":
            np.testing.assert_array_equal(resumed.table[name], whole.table[name])
    np.testing.assert_array_equal(resumed.positions(-1), whole.positions(-1))


@pytest.mark.parametrize("unit", [1e-6, 1e6])
def test_units_do_not_matter(unit: float) -> None:
    """All stiffnesses and forces times a factor: the same shapes, energies times the factor."""
    text = coil(stop='"0.1 pi"').text
    one = derod.push(derod.parse_scene(text))
    big = coil(stop='"0.1 pi"').replace(
        {
            "rod.bending": unit,
            "rod.twisting": 0.9 * unit,
            "drop.capillary_force": 20 * unit,
            "drop.wall_strength": 2e-4 * unit,
        }
    )
    scaled = derod.push(big)
    np.testing.assert_allclose(scaled.positions(-1), one.positions(-1), atol=1e-8)
    tension = one.table["end_tension"][-1]
    assert scaled.table["end_tension"][-1] == pytest.approx(unit * tension, rel=1e-7)


def test_targets_never_leave_a_sliver() -> None:
    stride = Stride(2.0, 2.0)
    for length, here, goal, target in (
        (2.0, 0.0, 1.0, 1.0),
        (0.6, 0.0, 1.0, 0.5),
        (0.2, 0.0, 1.0, 0.2),
        (0.2, 1.0, 0.0, 0.8),
    ):
        stride.length = length
        assert stride.target(here, goal) == target


def test_landings_already_passed_are_refused_on_resume(tmp_path: Path) -> None:
    path = tmp_path / "run.h5"
    derod.push(coil(stop='["0.03 pi", "0.01 pi"]'), path).close()
    longer = coil(stop='["0.03 pi", "0.005 pi"]', at='["0.007 pi"]')
    with pytest.raises(SceneError, match=r"push\.at = .* has been passed"):
        derod.push(longer.replace({"push.at": ["0.02 pi"]}), resume=path)
    with derod.push(longer, resume=path) as run:
        assert run.table["end_shortening"][run.table["landing"]][-2] == longer.push.at[0]
