"""The paper's equations coded again, as printed, and solved by scipy's ``solve_bvp``.

15 + 15 unknown functions (x, y, z, d_1, d_3, m, n on [0, sigma] and on [sigma, l/2], both mapped to
[0, 1]) and the parameters y_C, f_B, sigma; nothing of eq:18d-equilibre is reduced here.
"""

import numpy as np
import pytest
from scipy.integrate import solve_bvp

from derod.branches.half_rod.closure import DELTA, FGAMMA
from derod.branches.half_rod.mesh import adapted
from derod.branches.half_rod.mirror import FULL, LOOP_EVEN
from derod.branches.half_rod.observables import observables
from derod.branches.half_rod.parameters import Parameters
from derod.branches.paths.arc import Control, frozen
from derod.branches.paths.catalogue import Catalogue
from derod.branches.paths.newton import settle

pytestmark = pytest.mark.validation
L, K3, FG, RHO = 10.0, 0.9, 20.0, 0.1
FIXED = np.stack([frozen(FGAMMA), frozen(DELTA)])


def printed_rates(u, y_centre, v0, wet):
    """eq:18d-equilibre, line by line."""
    x, y, z, d1x, d1y, d1z, d3x, d3y, d3z, mx, my, mz, nx, ny, nz = u
    u3 = (mx * d3x + my * d3y + mz * d3z) / K3
    out = np.empty_like(u)
    out[0], out[1], out[2] = d3x, d3y, d3z
    out[3] = d1z * my - d1y * mz + (1 - K3) * u3 * (d1z * d3y - d1y * d3z)
    out[4] = d1x * mz - d1z * mx + (1 - K3) * u3 * (d1x * d3z - d1z * d3x)
    out[5] = d1y * mx - d1x * my + (1 - K3) * u3 * (d1y * d3x - d1x * d3y)
    out[6] = d3z * my - d3y * mz
    out[7] = d3x * mz - d3z * mx
    out[8] = d3y * mx - d3x * my
    out[9] = d3z * ny - d3y * nz
    out[10] = d3x * nz - d3z * nx
    out[11] = d3y * nx - d3x * ny
    out[12:] = 0.0
    if wet:
        r = np.sqrt(x**2 + (y - y_centre) ** 2 + z**2)
        slope = 2.0 * v0 / (1.0 + RHO - 2.0 * r) ** 2 / np.maximum(r, 1e-12)
        out[12], out[13], out[14] = slope * x, slope * (y - y_centre), slope * z
    return out


def residual(v0, delta):
    """33 conditions: eq:initcond (9), the meniscus (15 + 3), the clamp (5 + delta)."""

    def conditions(a, b, p):
        y_centre, force, _ = p
        s, e, o, c = a[:15], b[:15], a[15:], b[15:]
        centre = np.array([0.0, y_centre, 0.0])
        lever = e[:3] - centre
        jump = np.zeros(15)
        jump[12:] = 2.0 * force * lever
        wall = v0 / (1.0 + RHO - 2.0 * np.linalg.norm(lever))
        return np.concatenate(
            [
                [s[0], s[2], s[7], s[4], s[13], s[10]],
                [s[6] ** 2 + s[8] ** 2 - 1.0, s[3] - s[8], s[5] + s[6]],
                o - e - jump,
                [np.linalg.norm(lever) - 0.5],
                [o[13]],  # n_y(sigma+) = 0, after the jump
                [2.0 * force * (-lever @ e[6:9]) + FG - wall],
                [c[0], c[1], c[6], c[7], c[4], c[2] - 0.5 * (L - delta)],
            ]
        )

    return conditions


def printed_functions(state, at_inner, at_outer):
    """The 30 functions of a half-rod state at fractions of the two intervals."""
    from derod.branches.half_rod.element import moment, tangent
    from derod.branches.half_rod.fields import evaluate_fields, interpolate

    fields = evaluate_fields(state)
    y_centre = -state.nodes[-1, 1]
    columns = []
    for at, first, last in (
        (at_inner, 0, state.inner),
        (at_outer, state.inner, state.eta.size),
    ):
        ends = np.concatenate([[0.0], np.cumsum(state.eta[first:last])])
        element = np.clip(np.searchsorted(ends, at, side="right") - 1, 0, last - first - 1)
        share = (at - ends[element]) / state.eta[first:last][element]
        rows = []
        for y in interpolate(state, fields, element + first, share):
            w, q, n = y[:3], y[3:7], y[7:10]
            t, m = np.empty(3), np.empty(3)
            tangent(q, t)
            moment(state.scalars[0], state.scalars[1], w, n, m)
            d1 = [
                q[0] ** 2 + q[1] ** 2 - q[2] ** 2 - q[3] ** 2,
                2 * (q[1] * q[2] + q[0] * q[3]),
                2 * (q[1] * q[3] - q[0] * q[2]),
            ]
            place = w + np.array([0.0, y_centre, 0.0])
            rows.append(np.concatenate([place, d1, t, m, n]))
        columns.append(np.array(rows).T)
    return np.vstack(columns), y_centre


@pytest.fixture(scope="module", params=[2e-4, 2e-2])
def catalogue(request):
    out = Catalogue(Parameters(wall_strength=request.param), Control(largest_step=0.3))
    list(out.succession())
    return request.param, out


@pytest.mark.parametrize(("name", "delta"), [("Ax", 0.15), ("3D", 0.45), ("3D", 1.2), ("L2", 2.12)])
def test_agrees_with_solve_bvp(catalogue, name, delta):
    v0, paths = catalogue
    delta *= np.pi
    points = paths.paths[name].points
    near = min(points, key=lambda p: abs(p.state.end_shortening - delta))
    mirror = FULL if name == "3D" else LOOP_EVEN
    values = np.array([FG, delta])
    state = settle(adapted(near.state, 2.0), mirror, FIXED, values, 1e-11, 30).state
    own = observables(state)
    mesh = np.unique(
        np.concatenate(
            [
                [0.0, 1.0],
                *(
                    np.cumsum(part)[:-1]
                    for part in (state.eta[: state.inner], state.eta[state.inner :])
                ),
            ]
        )
    )
    mesh = np.unique(np.concatenate([mesh, 0.5 * (mesh[1:] + mesh[:-1])]))
    start, y_centre = printed_functions(state, mesh, mesh)
    rng = np.random.default_rng(3)
    start = start * (1.0 + 1e-3 * rng.normal(size=start.shape))  # not handed the answer

    def rates(x, u, p):
        sigma = p[2]
        inner = sigma * printed_rates(u[:15], p[0], v0, True)
        outer = (0.5 * L - sigma) * printed_rates(u[15:], p[0], v0, False)
        return np.vstack([inner, outer])

    guess = np.array([y_centre, own["meniscus_force"], state.sigma])
    solution = solve_bvp(
        rates, residual(v0, delta), mesh, start, p=guess, tol=1e-7, max_nodes=20000
    )
    assert solution.success, solution.message
    tension = solution.y[15 + 12 :, -1] @ solution.y[15 + 6 : 15 + 9, -1]
    assert tension == pytest.approx(own["end_tension"], rel=2e-6)
    assert 2.0 * solution.p[2] == pytest.approx(own["wetted_length"], abs=2e-6)
    assert solution.p[1] == pytest.approx(own["meniscus_force"], rel=2e-6)
    assert solution.p[0] == pytest.approx(own["drop_y"], abs=2e-6)
