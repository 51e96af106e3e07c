"""Paths: laws along them, folds and branch points, against pushes and known places."""

from __future__ import annotations

import math

import numpy as np
import pytest

import derod
from derod.pushing.controls import CONTROLS
from derod.tracing.arc import Arc
from derod.tracing.path import Limits
from derod.tracing.special import BRANCH_POINT, FOLD, JOINT
from derod.tracing.starting import both_ways, sheets, start_point
from derod.tracing.switching import switch
from tests.scenes import coil
from tests.tracing.paths import planar, side


def places(kind: str) -> list[float]:
    return [one.value / math.pi for one in planar()[1].specials if one.kind == kind]


def test_the_planar_path_goes_through_both_of_its_folds_until_the_outer_rod_has_run_out() -> None:
    """The boundary-value problem has the first fold at 1.3312 pi."""
    _, path = planar()
    folds = places(FOLD)
    assert len(folds) == 2
    assert folds[0] == pytest.approx(1.3312, abs=5e-4)
    assert path.ends == "the outer rod has run out"


def test_the_first_pitchfork_and_the_flip_odd_one_behind_it() -> None:
    """0.24305 pi at t = 12.9116; near 0.49 pi the half rod marks nothing."""
    _, path = planar()
    first, second = [one for one in path.specials if one.kind == BRANCH_POINT][:2]
    assert first.value / math.pi == pytest.approx(0.24305, abs=2e-5)
    assert first.point.here.tension == pytest.approx(12.9116, abs=2e-3)
    assert second.value / math.pi == pytest.approx(0.4899, abs=5e-4)
    assert (first.change, second.change) == (1, 1)


def test_special_points_do_not_depend_on_the_steps() -> None:
    """Folds and branch points are located to 1e-8 of the control, from another sequence of steps as well."""
    arc, path = planar()
    other = both_ways(arc, path.points[20].state, Limits(longest=0.23, first=0.013))
    assert other is not None
    for kind in (FOLD, BRANCH_POINT):
        mine = [one for one in path.specials if one.kind == kind][:2]
        for one in mine:
            again = min(
                (s for s in other.specials if s.kind == kind),
                key=lambda s: abs(s.value - one.value),
            )
            assert again.value == pytest.approx(one.value, rel=1e-8)


def test_the_energy_changes_by_the_work_of_the_end() -> None:
    """dE/d delta = -t all along a path, by differences of steps to both sides."""
    arc, path = planar()
    points = [point for point in path.points[5:-5:6] if abs(point.rate) > 0.1]
    assert len(points) > 10
    for point in points:
        back, ahead = arc.step(point, None, -1e-3), arc.step(point, None, 1e-3)
        assert back is not None
        assert ahead is not None
        slope = (ahead.here.energy - back.here.energy) / (ahead.value - back.value)
        assert slope == pytest.approx(-point.here.tension, rel=1e-4)


def test_the_count_of_the_bordered_matrix_is_that_of_the_hessian() -> None:
    arc, path = planar()
    for a, b in zip(path.points[3:-3:7], path.points[4:-2:7], strict=False):
        assert start_point(arc, a.state, b.value > a.value) is not None
        assert arc.bordered.count == a.count


def test_the_count_changes_only_at_special_points() -> None:
    for path in (planar()[1], side(0), side(1)):
        changes = sum(one.change for one in path.specials if one.kind != JOINT)
        assert path.points[-1].count - path.points[0].count == changes


def test_both_sides_of_a_pitchfork_are_images_of_each_other() -> None:
    arc, path = planar()
    special = next(one for one in path.specials if one.kind == BRANCH_POINT)
    one, other = switch(arc, special, 1.0), switch(arc, special, -1.0)
    assert one is not None
    assert other is not None
    assert one.value == pytest.approx(other.value, rel=1e-10)
    assert one.here.energy == pytest.approx(other.here.energy, rel=1e-10)
    assert one.count == 0  # the branch of the push


def test_the_space_path_joins_the_planar_one_with_two_loops() -> None:
    """At 2.05682 pi, t = 19.7332; the flip-odd one joins it at 1.8743 pi."""
    assert side(0).specials[-1].kind == side(1).specials[-1].kind == JOINT
    assert side(0).specials[-1].value / math.pi == pytest.approx(2.05682, abs=5e-4)
    assert side(1).specials[-1].value / math.pi == pytest.approx(1.8743, abs=1e-3)


@pytest.mark.parametrize("delta", [0.2, 0.3])
def test_a_push_records_states_of_the_paths(delta: float) -> None:
    """Planar before the pitchfork and in space behind it, to 1e-8."""
    run = derod.push(coil(edges=200, stop=f'"{delta} pi"', at=f'["{delta} pi"]'))
    row = run.at(f"{delta} pi")
    path = planar()[1] if delta < 0.243 else side(0)
    found = sheets(planar()[0], path, float(row.row["end_shortening"]))
    near = min(found, key=lambda one: abs(one.here.energy_hat - row.row["energy_hat"]))
    assert near.here.energy_hat == pytest.approx(row.row["energy_hat"], rel=1e-8)
    assert near.here.tension == pytest.approx(row.row["end_tension"], rel=1e-8)
    assert near.here.unstable_modes == row.row["unstable_modes"] == 0


def test_other_controls_are_followed_as_well() -> None:
    """The capillary force there and back: the slope of the energy is the conjugate, -(s_B - s_A)."""
    arc, path = planar()
    control = CONTROLS["capillary_force"]
    other = Arc(arc.system, control)
    way = both_ways(other, path.points[15].state, Limits(low=15.0, high=30.0))
    assert way is not None
    values = np.array([point.value for point in way.points])
    assert values.min() < 15.0 < 30.0 < values.max()
    energies = np.array([point.here.energy for point in way.points])
    slopes = np.array([point.here.conjugate for point in way.points])
    work = np.diff(values) * 0.5 * (slopes[1:] + slopes[:-1])
    assert np.diff(energies) == pytest.approx(work, rel=1e-2)
