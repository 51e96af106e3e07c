"""The condensed element against differences and against what the equations conserve."""

from dataclasses import replace

import numpy as np
import pytest

from derod.branches.half_rod.chain import expand_stages
from derod.branches.half_rod.closure import FGAMMA
from derod.branches.half_rod.element import moment, tangent, tangent_derivative, wall_gradient
from derod.branches.half_rod.fields import evaluate_fields
from derod.branches.half_rod.gauss import MATRIX, NODES, STAGES, WEIGHTS
from derod.branches.half_rod.linear import linearise
from derod.branches.half_rod.parameters import Parameters
from derod.branches.half_rod.state import HalfRod, Increment
from derod.branches.paths.arc import frozen

SHORT = Parameters(length=1.5, capillary_force=5.0, wall_strength=2e-2)
STRIP = replace(SHORT, bending_2=4.0, twisting=0.7)
CROSSED = replace(STRIP, director=0.5 * np.pi)
START = np.array([0.0, 0.1, 0.05, 0.99, 0.0, 0.1, 0.0, 0.5, 0.0, -1.0])
START[3:7] /= np.linalg.norm(START[3:7])
SCALARS = np.array([0.1, 0.2, 0.3, 0.25, 0.0, 5.0, 0.0])


def shot(start, scalars, inner=4, outer=3, parameters=SHORT):
    """The half rod as an initial-value problem: Newton on stages and nodes, the start held."""
    eta = np.concatenate([np.full(inner, 1 / inner), np.full(outer, 1 / outer)])
    nodes = np.tile(start, (inner + outer + 2, 1))
    stages = np.tile(start[3:7], (inner + outer, STAGES, 1))
    if parameters is not SHORT:  # Newton starts nearer
        near = SHORT
        if parameters.bending_2 > 2.0:
            near = replace(parameters, bending_2=0.5 * (1.0 + parameters.bending_2))
        begun, _ = shot(start, scalars, inner, outer, near)
        nodes, stages = begun.nodes, begun.stages
    state = HalfRod(parameters, eta, inner, nodes, stages, scalars)
    for _ in range(30):
        elements = linearise(state)
        step = np.zeros_like(nodes)
        for e in range(inner + outer):
            left = e if e < inner else e + 1
            if e == inner:
                step[left] = elements.jump_jacobian[:, :10] @ step[left - 1]
                step[left] += elements.jump_residual
            step[left + 1] = elements.A[e, :, :10] @ step[left] + elements.r[e]
        change = np.empty_like(stages)
        expand_stages(elements.X, inner, step, np.zeros(4), 1.0, change)
        state = state.moved(Increment(step, change, np.zeros(7)))
        if np.abs(step).max() < 1e-13:
            return state, linearise(state)
    raise AssertionError("the initial-value problem did not converge")


@pytest.mark.parametrize("parameters", [SHORT, STRIP, CROSSED])
def test_transfer_matrices_against_differences(parameters):
    _, elements = shot(START, SCALARS, parameters=parameters)
    whole, drive = np.eye(10), np.zeros((10, 4))
    for e in range(7):
        if e == 4:
            whole = elements.jump_jacobian[:, :10] @ whole
            drive = elements.jump_jacobian[:, :10] @ drive
        whole, drive = elements.A[e, :, :10] @ whole, elements.A[e, :, :10] @ drive
        drive += elements.A[e, :, 10:]
    exact = np.hstack([whole, drive])
    for k in range(14):
        ends = []
        for side in (1e-5, -1e-5):
            start, scalars = START.copy(), SCALARS.copy()
            (start if k < 10 else scalars)[k % 10] += side
            ends.append(shot(start, scalars, parameters=parameters)[0].nodes[-1])
        difference = (ends[0] - ends[1]) / 2e-5
        assert np.abs(difference - exact[:, k]).max() < 2e-8, k


def test_conserved_quantities_along_the_rod():
    state, _ = shot(START, SCALARS, 8, 8)
    assert np.abs(np.linalg.norm(state.nodes[:, 3:7], axis=1) - 1.0).max() < 1e-13
    wet = state.nodes[: state.inner + 1]
    # |m_perp|^2/2 + n.d3 - v is the Hamiltonian of the homogeneous part
    values = []
    for y in wet:
        m, t = np.empty(3), np.empty(3)
        moment(SCALARS[0], SCALARS[1], y[:3], y[7:10], m)
        tangent(y[3:7], t)
        gap = 1.0 + SHORT.wall_softness - 2.0 * np.linalg.norm(y[:3])
        across = m - (m @ t) * t
        values.append(0.5 * across @ across + y[7:10] @ t - SHORT.wall_strength / gap)
    assert np.ptp(values) < 1e-9


def test_outside_the_drop_the_force_is_uniform():
    state, _ = shot(START, SCALARS)
    outer = state.nodes[state.inner + 1 :, 7:10]
    assert np.array_equal(outer, np.broadcast_to(outer[0], outer.shape))


def test_wall_derivatives(rng):
    grad, hess, other = np.empty(3), np.empty((3, 3)), np.empty((3, 3))
    for _ in range(20):
        w = rng.normal(size=3)
        w *= rng.uniform(0.05, 0.545) / np.linalg.norm(w)

        def v(x):
            return 0.02 / (1.1 - 2.0 * np.linalg.norm(x))

        gap = wall_gradient(w, 0.02, 0.1, grad, hess)
        assert gap == pytest.approx(1.1 - 2.0 * np.linalg.norm(w), rel=1e-12)
        h = 1e-6 * gap
        for i in range(3):
            e = np.zeros(3)
            e[i] = h
            assert (v(w + e) - v(w - e)) / (2 * h) == pytest.approx(grad[i], rel=1e-5, abs=1e-7)
            up, down = np.empty(3), np.empty(3)
            wall_gradient(w + e, 0.02, 0.1, up, other)
            wall_gradient(w - e, 0.02, 0.1, down, other)
            scale = np.abs(hess).max()
            assert np.abs((up - down) / (2 * h) - hess[i]).max() < 1e-6 * scale


def test_tangent_derivative(rng):
    q = rng.normal(size=4)
    rate, ends = np.empty((3, 4)), np.empty((2, 3))
    tangent_derivative(q, rate)
    for i in range(4):
        e = np.zeros(4)
        e[i] = 0.5
        tangent(q + e, ends[0])
        tangent(q - e, ends[1])
        assert np.allclose(ends[0] - ends[1], rate[:, i], atol=1e-14)  # d_3 is quadratic in q


def test_gauss_tableau_integrates_polynomials():
    for power in range(2 * STAGES):
        assert WEIGHTS @ NODES**power == pytest.approx(1 / (power + 1), abs=1e-14)
    for power in range(STAGES):
        exact = NODES ** (power + 1) / (power + 1)
        assert np.allclose(MATRIX @ NODES**power, exact, atol=1e-14)


def test_fields_agree_with_the_printed_equations():
    """d3' = m x d3 and m' = n x d3 at the stages, from the collocation polynomial."""
    state, _ = shot(START, SCALARS, 8, 8)
    fields = evaluate_fields(state)
    h = state.lengths
    rate = np.linalg.inv(MATRIX)  # differentiates along the stages, from the left node
    left = np.arange(state.eta.size) + (np.arange(state.eta.size) >= state.inner)
    start = np.empty((state.eta.size, 3))
    for e, node in enumerate(left):
        tangent(state.nodes[node, 3:7], start[e])
    slope = np.einsum("jk,eki->eji", rate, fields.tangents - start[:, None]) / h[:, None, None]
    assert np.abs(slope - np.cross(fields.moments, fields.tangents)).max() < 1e-5


def test_frozen_picks_one_unknown():
    assert frozen(FGAMMA).sum() == 1.0
    assert frozen(FGAMMA)[FGAMMA] == 1.0
