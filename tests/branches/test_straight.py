"""The straight rod and its buckling."""

import numpy as np
import pytest

from derod.branches.half_rod.linear import linearise
from derod.branches.half_rod.mirror import STRAIGHT_LOOP, STRAIGHT_S, STRAIGHT_TWISTED
from derod.branches.half_rod.parameters import Parameters
from derod.branches.paths.stability import unstable_modes
from derod.branches.paths.straight import NoBuckling, buckling_tensions, straight_state


@pytest.mark.parametrize("rotation", [0.0, 2.0, 2.0 * np.pi])
def test_the_straight_state_solves_the_equations(rotation):
    elements = linearise(straight_state(Parameters(end_rotation=rotation), 7.0))
    assert elements.residual < 1e-9
    assert elements.meniscus_force == pytest.approx(20.0 - 2e-3, rel=1e-12)


@pytest.mark.parametrize(("strength", "tension"), [(2e-4, 3.7246), (2e-2, 3.613)])
def test_buckling_tension(strength, tension):
    """The paper: t about 3.7. The wall's cone leaves its mark on the third digit."""
    found = buckling_tensions(Parameters(wall_strength=strength), STRAIGHT_LOOP)[0]
    assert found == pytest.approx(tension, abs=2e-3)


def test_without_a_wall_buckling_is_that_of_a_compressed_beam():
    """Half length 1/2 under t - f_gamma, then l/2 - 1/2 under t: the determinant in closed form."""
    rod = Parameters(wall_strength=1e-12, capillary_force=20.0, length=10.0)
    t = buckling_tensions(rod, STRAIGHT_LOOP)[0]
    k, q, outer = np.sqrt(20.0 - t), np.sqrt(t), 4.5
    # Even mode about the drop's centre y(s) - y_C with n_y = 0 outside. The inner lateral force is
    # minus the jump f_gamma w_y / w_z = 2 f_gamma w_y(1/2). Inner: w = a cos(k s) + n_y-balance.
    # Matched slope and curvature at s = 1/2, slope zero at l/2: y' ~ sinh(q (l/2 - s)).
    # inner: y'' = -k^2 (w - w0), y' = -a k sin(k s), moment continuous: y''(1/2) = y' * (-q coth)
    slope, bend = -k * np.sin(0.5 * k), -(k**2) * np.cos(0.5 * k)
    assert bend * np.tanh(q * outer) == pytest.approx(-q * slope, rel=1e-6)


def test_buckling_adds_one_unstable_mode_in_each_plane():
    tension = buckling_tensions(Parameters(), STRAIGHT_LOOP)[0]
    assert unstable_modes(straight_state(Parameters(), tension + 0.3)) == (0, 0)
    assert unstable_modes(straight_state(Parameters(), tension - 0.3)) == (1, 1)


def test_a_weak_drop_buckles_nothing():
    with pytest.raises(NoBuckling, match="does not buckle"):
        buckling_tensions(Parameters(capillary_force=20.0), STRAIGHT_S)


def test_twist_raises_the_buckling_tension():
    twisted = buckling_tensions(Parameters(end_rotation=2 * np.pi), STRAIGHT_TWISTED)[0]
    plain = buckling_tensions(Parameters(), STRAIGHT_LOOP)[0]
    assert twisted > plain
