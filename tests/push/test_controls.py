"""Every control by itself: its conjugate and its slope are derivatives, and its pushes keep the laws."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest

import derod
from derod.equilibrium.loop import relax
from derod.equilibrium.measured import Measured, measure
from derod.equilibrium.methods import make_relaxer
from derod.errors import SceneError
from derod.pushing.controls import CONTROLS
from derod.pushing.driver import Push
from derod.pushing.frames import Outcome
from derod.pushing.rows import ROW
from derod.scene import Scene
from derod.scene.controls import HELD
from tests.scenes import coil

sys.path.insert(0, str(Path(__file__).parents[2] / "runs"))
from controls import closed_form

STEPS = {
    "end_shortening": 1e-3,
    "end_tension": 1e-2,
    "end_rotation": 1e-2,
    "capillary_force": 1e-2,
    "wall_strength": 1e-6,
    "weight": 1e-2,
}


def settled(name: str) -> tuple[Push, Measured]:
    """A coil under a heavy drop, measured along a control; its end slides where that is the control."""
    scene = coil(edges=50, stop='"0.6 pi"', rotation=0.4).replace({"drop.weight": 1.0})
    if name == "end_tension":  # stable under its load only where dt/ddelta < 0
        scene = scene.replace({"push.stop": "1.0 pi", "steps": [{"control": name, "stop": 18.4}]})
    push = Push(scene, [])
    push.begin()
    push.run()
    assert push.here is not None
    push.steer(name, HELD[name].step(scene))
    push.remeasure()
    return push, push.here


def test_every_control_is_held_somewhere_and_has_a_column() -> None:
    assert set(CONTROLS) == set(HELD)
    for name, control in CONTROLS.items():
        assert name in (ROW.names or ())
        assert control.name == name and control.symbol and control.unit


@pytest.mark.parametrize("name", CONTROLS)
def test_conjugate_and_slope_are_derivatives_along_the_branch(name: str) -> None:
    push, here = settled(name)
    control, h = CONTROLS[name], STEPS[name]
    found = []
    for side in (-2, -1, 1, 2):
        guess = here.state.copy()
        guess.q += side * h * here.slope_q
        guess.b += side * h * here.slope_b
        control.set(guess, here.control_value + side * h)
        solution = relax(make_relaxer("implicit"), push.system, guess)
        assert solution.converged, solution.message
        found.append(measure(push.system, solution.state, control))

    def derivative(values: list[float]) -> float:
        a, b, c, d = values
        return (8 * (c - b) - (d - a)) / (12 * h)

    potential = derivative([there.energy for there in found])
    assert potential == pytest.approx(here.conjugate, rel=1e-6, abs=1e-7)
    stiffness = derivative([there.conjugate for there in found])
    assert stiffness == pytest.approx(here.stiffness, rel=2e-5, abs=1e-6)
    slope = sum(w * there.state.q for w, there in zip((1, -8, 8, -1), found, strict=True)) / (
        12 * h
    )
    np.testing.assert_allclose(
        slope[1:-1, :3], here.slope_q[1:-1, :3], atol=2e-4 * (1 + np.abs(slope).max())
    )


def under_tension(stops: list[float], at: list[float], end: str = "1.0 pi") -> Scene:
    """A coil at 1 pi whose end is then let go under a pull."""
    step = {"control": "end_tension", "stop": stops, "at": at}
    return coil(edges=80, stop=f'"{end}"', wall=2e-2).replace({"steps": [step]})


def test_the_states_under_a_pull_are_those_of_the_push() -> None:
    run = derod.push(under_tension([17.4], [18.2, 17.8]))
    assert run.outcome is Outcome.COMPLETED, run.ending
    rows = run.table[(run.table["segment"] == 1) & run.table["landing"]]
    deltas = [float(x) for x in rows["end_shortening"]]
    assert (np.diff(deltas) > 0).all()
    other = derod.push(coil(edges=80, stop=f"{deltas[-1]!r}", at=repr(deltas[:-1]), wall=2e-2))
    for row in rows:
        (same,) = other.table[other.table["end_shortening"] == row["end_shortening"]]
        for name in ("end_tension", "energy_hat", "wetted_length", "force_a"):
            assert same[name] == pytest.approx(row[name], rel=1e-8), name


def test_a_pull_above_every_maximum_straightens_the_rod_and_below_every_minimum_winds_it_in() -> (
    None
):
    up = derod.push(under_tension([21.0], []))
    (snap,) = [event for event in up.events if event.kind == "snap"]
    assert 19.5 < snap.control_value < 20.2  # the maximum of t(delta), located
    assert "end-shortening" in snap.message and "energy lost" in snap.message
    assert abs(up.table["end_shortening"][-1]) < 1e-9
    assert up.outcome is Outcome.COMPLETED
    down = derod.push(under_tension([12.0], []))
    assert down.outcome is Outcome.ROD_RAN_OUT
    assert down.ending is not None and "none is left" in down.ending.message
    assert down.table["converged"].all() and not down.table["unstable_modes"].any()


GREENHILL = """
[rod]
length = 1
bending = 1
twisting = 0.9
[clamps]
end_tension = {tension}
[push]
control = "end_rotation"
stop = {stop}
max_step = "0.05 pi"
[mesh]
edges = {edges}
[model]
drop = false
"""


def buckling_moment(tension: float, edges: int) -> float:
    """The moment at which the discrete rod's straight state loses its stability."""
    stop = 1.01 * closed_form(tension) / 0.9
    run = derod.push(derod.parse_scene(GREENHILL.format(tension=tension, edges=edges, stop=stop)))
    event = next(event for event in run.events if event.kind == "instability")
    return 0.9 * event.control_value


@pytest.mark.parametrize("tension", [0.0, 1.0, 10.0, 30.0])
def test_a_twisted_rod_under_tension_buckles_where_greenhill_says(tension: float) -> None:
    exact = closed_form(tension)
    assert buckling_moment(tension, 50) == pytest.approx(exact, rel=1e-4)


def test_the_buckling_moment_converges_faster_than_third_order() -> None:
    exact = closed_form(10.0)
    coarse, fine = (abs(buckling_moment(10.0, n) - exact) for n in (40, 80))
    assert np.log2(coarse / fine) > 3.2


def test_capillary_force_up_and_down_again_is_a_closed_loop() -> None:
    """At fixed end-shortening the states come back, and the work is what the energy says."""
    scene = coil(edges=60).replace(
        {
            "push.control": "capillary_force",
            "clamps.end_shortening": "0.6 pi",
            "push.start": 20.0,
            "push.stop": [28.0, 20.0],
            "push.at": [24.0],
            "push.max_step": 0.4,
        }
    )
    run = derod.push(scene)
    assert run.outcome is Outcome.COMPLETED
    table = run.table
    assert set(table["end_shortening"]) == {0.6 * np.pi}
    first, last = table[0], table[-1]
    assert (first["capillary_force"], last["capillary_force"]) == (20.0, 20.0)
    for name in ("energy_total", "end_tension", "wetted_length"):
        assert last[name] == pytest.approx(first[name], rel=1e-9)
    assert np.abs(table["work_defect"]).max() < 1e-4
    force, wetted = table["capillary_force"], table["wetted_length"]
    work = -np.sum(0.5 * (wetted[1:] + wetted[:-1]) * np.diff(force))
    half = int(np.argmax(force))
    one_way = -np.sum(0.5 * (wetted[1 : half + 1] + wetted[:half]) * np.diff(force[: half + 1]))
    gained = table["energy_total"][half] - first["energy_total"]
    assert gained == pytest.approx(one_way, rel=1e-4)
    assert abs(work) < 1e-5  # the quadrature's error, of 2.6 each way


def steps_scene() -> Scene:
    """Push, turn the end, pull back, lower the capillary force, add weight."""
    return coil(edges=50, stop='"0.5 pi"').replace(
        {
            "steps": [
                {"control": "end_rotation", "stop": "0.5 pi", "at": ["0.25 pi"]},
                {"control": "end_shortening", "stop": "0.4 pi"},
                {"control": "capillary_force", "stop": 18.0},
                {"control": "weight", "stop": 1.0, "max_step": 0.25},
            ]
        }
    )


def test_steps_are_followed_one_after_another() -> None:
    run = derod.push(steps_scene())
    assert run.outcome is Outcome.COMPLETED, run.ending
    table = run.table
    assert list(np.unique(table["segment"])) == [0, 1, 2, 3, 4]
    last = table[-1]
    assert last["end_rotation"] == 0.5 * np.pi and last["end_shortening"] == 0.4 * np.pi
    assert last["capillary_force"] == 18.0 and last["weight"] == 1.0
    assert table["converged"].all() and not table["unstable_modes"].any()
    assert 0.25 * np.pi in table["end_rotation"][table["landing"]]
    assert sum(event.kind == "turn" for event in run.events) == 4


@pytest.mark.parametrize("frames", [3, 30, 45])
def test_a_push_in_steps_resumes_bit_for_bit(tmp_path: Path, frames: int) -> None:
    whole = derod.push(steps_scene(), tmp_path / "whole.h5")

    class Stop:
        def start(self, scene, first_increment): ...
        def event(self, event): ...
        def finish(self, ending): ...
        def frame(self, frame):
            if frame.row["increment"] == frames:
                raise KeyboardInterrupt

    run = derod.push(steps_scene(), tmp_path / "part.h5", observers=[Stop()])
    assert run.outcome is Outcome.INTERRUPTED and len(run) <= frames + 1
    run.close()
    again = derod.push(None, resume=tmp_path / "part.h5")
    assert len(again) == len(whole)
    for name in ROW.names or ():
        if name != "wall_time":
            np.testing.assert_array_equal(again.table[name], whole.table[name], err_msg=name)


@pytest.mark.parametrize(
    ("changes", "key"),
    [
        ({"push.control": "force"}, "push.control"),
        ({"push.control": "weight", "push.stop": 1.0}, "clamps.end_shortening"),
        ({"clamps.end_tension": 5.0}, "clamps.end_tension"),
        ({"steps": [{"control": "end_rotation"}]}, "steps[0].stop"),
        ({"steps": [{"control": "spin", "stop": 1.0}]}, "steps[0].control"),
        ({"steps": [{"control": "wall_strength", "stop": -1.0}]}, "steps[0].stop"),
        ({"steps": [{"control": "end_rotation", "stop": 1.0, "at": [2.0]}]}, "steps[0].at[0]"),
        ({"steps": {"control": "weight"}}, "steps"),
        (
            {"model.dimension": 2, "steps": [{"control": "end_rotation", "stop": 1.0}]},
            "steps[0].control",
        ),
        (
            {"relax.method": "fire", "steps": [{"control": "end_tension", "stop": 1.0}]},
            "relax.method",
        ),
        ({"drop.weight": -1.0}, "drop.weight"),
        ({"push.bend": "left"}, "push.bend"),
    ],
)
def test_controls_that_make_no_sense_are_refused(changes: dict[str, object], key: str) -> None:
    with pytest.raises(SceneError) as caught:
        coil().replace(changes)
    assert caught.value.key == key
    assert "allowed" in str(caught.value)


def test_a_scene_with_steps_reads_back_equal() -> None:
    scene = steps_scene()
    assert derod.parse_scene(scene.text) == scene
    assert "[[steps]]" in scene.text
