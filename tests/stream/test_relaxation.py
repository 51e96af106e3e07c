"""The steps inside an increment, streamed."""

import numpy as np
import pytest

import derod
from derod.equilibrium.loop import Report
from derod.pushing.frames import Ending, Event, Outcome
from derod.rod.physics import constants
from derod.rod.state import State
from derod.views.stream.observer import MOST_STEPS, RelaxationWatch, RerunStream
from tests.stream.reading import read_rrd
from tests.synthetic import make_frame, small_scene


class Kept:
    def __init__(self):
        self.steps = []

    def step(self, step):
        self.steps.append(step)


def a_state() -> State:
    return State(np.zeros((5, 4)), np.arange(8.0), 0.0, 0.3, constants(3, 10.0, drop=True))


def steps(watch, increment, count):
    for k in range(count):
        watch.relaxation(
            increment, k, a_state(), Report(1, 1.0, 10.0**-k if k < 300 else 0, True, True)
        )


def test_only_chosen_increments_are_kept():
    kept = Kept()
    watch = RelaxationWatch(kept, frozenset([1]))
    for increment in range(3):
        steps(watch, increment, 4)
        watch.frame(make_frame(increment, 4))
    assert [step.increment for step in kept.steps] == [1] * 4
    assert [step.number for step in kept.steps] == [0, 1, 2, 3]


def test_events_choose_their_increment():
    kept = Kept()
    watch = RelaxationWatch(kept, None)
    for increment, kind in enumerate(("halving", "snap", "turn")):
        steps(watch, increment, 3)
        watch.event(Event(increment, kind, 0.1, 2.0, 1.0, ""))
        watch.frame(make_frame(increment, 4))
    assert {step.increment for step in kept.steps} == {1}


def test_an_increment_that_never_settles_is_shown():
    kept = Kept()
    watch = RelaxationWatch(kept, None)
    steps(watch, 7, 5)
    watch.finish(Ending(Outcome.NOT_CONVERGED, "", 0.1))
    assert len(kept.steps) == 5


def test_long_relaxations_are_thinned():
    kept = Kept()
    watch = RelaxationWatch(kept, frozenset([0]))
    steps(watch, 0, 5 * MOST_STEPS)
    watch.frame(make_frame(0, 4))
    assert MOST_STEPS / 2 <= len(kept.steps) <= MOST_STEPS


def test_a_push_streams_its_steps(tmp_path):
    path = tmp_path / "steps.rrd"
    scene = small_scene(mesh__edges=40, push__stop="0.03 pi", push__at=[])
    stream = RerunStream(str(path))
    run = derod.push(scene, observers=[RelaxationWatch(stream, frozenset([1, 2])), stream])
    contents = read_rrd(path)
    tube = contents["world/rod/tube"]
    steps_seen = [k for k in tube.times["relaxation"] if k is not None]
    assert len(steps_seen) >= run.table["iterations"][1:3].sum() > 0
    residual = [v[0] for v in contents["plots/relaxation"].values("Scalars:scalars")]
    assert len(residual) == len(steps_seen)
    assert residual[-1] < residual[0]
    words = [text[0] for text in contents["events"].values("TextLog:text")]
    assert sum("toward increment" in word for word in words) == len(steps_seen)
    assert contents["plots/tension"].rows == len(run)


def test_watching_changes_nothing():
    scene = small_scene(mesh__edges=40, push__stop="0.03 pi", push__at=[])
    plain = derod.push(scene)
    watched = derod.push(scene, observers=[RelaxationWatch(Kept(), None)])
    for name in plain.table.dtype.names:
        if name != "wall_time":
            assert plain.table[name] == pytest.approx(watched.table[name], abs=0), name


def test_forces_are_in_units_of_the_scene():
    """States count in K/D^2; what is shown is in K0/D^2, like the rows of the run."""
    kept = Kept()
    watch = RelaxationWatch(kept, frozenset([0]))
    watch.start(small_scene().replace({"rod.bending": 2.0}), 0)
    state = a_state()
    state.q[1:, 3] = 3.0
    watch.relaxation(0, 0, state, Report(1, 1.0, 0.5, True, True))
    watch.frame(make_frame(0, 4))
    (step,) = kept.steps
    assert step.residual == 1.0
    np.testing.assert_array_equal(step.edge_tension, 6.0)
    assert step.forces == tuple(2 * force for force in state.forces)
