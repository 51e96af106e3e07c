"""The jump and the conditions against differences, and as the paper prints them."""

import numpy as np
import pytest

from derod.branches.half_rod import closure as col
from derod.branches.half_rod.closure import conditions, jump
from derod.branches.half_rod.element import tangent


def node(rng):
    y = rng.normal(size=10)
    y[3:7] /= np.linalg.norm(y[3:7])
    return y


def test_jump_is_radial_and_balances_the_tension(rng):
    """eq:bcnd-end and sys:tension-jump: n+ - n- = 2 f_B w, T+ - T- = f_gamma - v."""
    y, after, jacobian = node(rng), np.empty(10), np.empty((10, 11))
    force = jump(y, 20.0, 0.002, after, jacobian)
    t = np.empty(3)
    tangent(y[3:7], t)
    assert np.allclose(after[7:] - y[7:], 2.0 * force * y[:3], atol=1e-13)
    assert (after[7:] - y[7:]) @ t == pytest.approx(20.0 - 0.002, abs=1e-12)
    printed = 2.0 * force * (-y[0] * t[0] - y[1] * t[1] - y[2] * t[2])
    assert printed == pytest.approx(-20.0 + 0.002, abs=1e-12)


def test_jump_jacobian(rng):
    y, jacobian, scratch = node(rng), np.empty((10, 11)), np.empty((10, 11))
    jump(y, 20.0, 0.002, np.empty(10), jacobian)
    for k in range(11):
        ends = []
        for side in (1e-6, -1e-6):
            z, force = y.copy(), 20.0
            if k < 10:
                z[k] += side
            else:
                force += side
            out = np.empty(10)
            jump(z, force, 0.002, out, scratch)
            ends.append(out)
        difference = (ends[0] - ends[1]) / 2e-6
        assert np.allclose(difference, jacobian[:, k], atol=1e-7 * np.abs(jacobian).max())


@pytest.mark.parametrize("rotation", [0.0, 1.3, 2.0 * np.pi])
def test_conditions_jacobian(rng, rotation):
    U = rng.normal(size=37)

    def residual(V):
        after, jacobian = np.empty(10), np.empty((10, 11))
        jump(V[10:20], V[col.FGAMMA], 0.002, after, jacobian)
        F, J = np.empty(14), np.empty((14, 37))
        conditions(V, 5.0, 0.9, rotation, after, jacobian, F, J)
        return F, J

    _, J = residual(U)
    for k in range(37):
        e = np.zeros(37)
        e[k] = 1e-6
        difference = (residual(U + e)[0] - residual(U - e)[0]) / 2e-6
        assert np.allclose(difference, J[:, k], atol=1e-6 * max(1.0, np.abs(J).max())), k


@pytest.mark.parametrize(("turn", "holds"), [(0.0, True), (1.0, False), (2.0, True)])
def test_end_rotation_is_told_from_its_double(turn, holds):
    """d_1y(l/2) = 0 holds for R = 0 and 2 pi; the condition used tells them apart (modulo 4 pi)."""
    U = np.zeros(37)
    half = turn * np.pi  # alpha_L = R/2 = turn pi
    U[23], U[26] = np.cos(0.5 * half), np.sin(0.5 * half)
    U[12] = 1.0
    after, jacobian, F, J = np.empty(10), np.empty((10, 11)), np.empty(14), np.empty((14, 37))
    conditions(U, 5.0, 0.9, 0.0, after, jacobian, F, J)
    assert (abs(F[col.CLAMP_TURN]) < 1e-12) == holds
    conditions(U, 5.0, 0.9, 2.0 * np.pi, after, jacobian, F, J)
    assert (abs(F[col.CLAMP_TURN]) < 1e-12) != holds
