"""The second variation as one dense matrix: the reference of ``derod.branches.half_rod.second_variation``.

Variations of the whole rod at fixed clamps: frames turn by phi(s), the centre line moves by rho
with rho' = phi x d_3, the drop's centre by rho_C, the menisci by b along the rod. To second order
twice the Lagrangian (fixed multipliers n, f_B) is

    int [ phi'.K phi' - phi'.(m x phi) + (n.d_3)|phi|^2 - (n.phi)(d_3.phi) ] ds
      + int_wet eta.(grad grad v) eta ds,      eta = rho - rho_C,
      + 2 sum over menisci of f_B (|rho + b d_3 - rho_C|^2 + w.(b^2 d_3' + 2 b rho')) +- (b grad
      v.eta + b^2 grad v.d_3/2)

on the kernel of the constraints rho(0) = rho(l) = 0, phi = 0 at the clamps, w.(rho + b d_3 -
rho_C) = 0. A flip-symmetric state splits it into flip-even and flip-odd variations of half the
rod. phi is piecewise quadratic and rho its exact integral, so this is a Ritz method: it converges
from above and needs no multiplier for inextensibility. Turning the coil about the clamp axis (phi = e_z
- d_3) is penalised where the drop has no weight and the section one stiffness, and so is the slip b of
the menisci in flip-odd variations, where they move along the rod together.
"""

from __future__ import annotations

import numpy as np
from scipy.linalg.lapack import dsytrf

from derod.branches.half_rod.closure import jump
from derod.branches.half_rod.element import moment, tangent
from derod.branches.half_rod.fields import evaluate_fields, interpolate
from derod.branches.half_rod.gauss import MATRIX, NODES, WEIGHTS
from derod.branches.half_rod.mesh import adapted
from derod.branches.half_rod.second_variation import core_radius
from derod.branches.half_rod.state import HalfRod

PENALTY = 1e6
"""On the constraints; their kernel is reached as it grows."""
NEUTRAL_PENALTY = 1e2

_SHAPE = np.stack(
    [(1 - NODES) * (1 - 2 * NODES), 4 * NODES * (1 - NODES), NODES * (2 * NODES - 1)], axis=1
)
_SLOPE = np.stack([4 * NODES - 3, 4 - 8 * NODES, 4 * NODES - 1], axis=1)


def cross_matrix(a: np.ndarray) -> np.ndarray:
    """[a x] (..., 3, 3) of vectors (..., 3)."""
    zero = np.zeros(a.shape[:-1])
    x, y, z = a[..., 0], a[..., 1], a[..., 2]
    rows = [[zero, -z, y], [z, zero, -x], [-y, x, zero]]
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)


def _rod_form(tangents, first, forces, moments, lengths, section):  # type: ignore[no-untyped-def]
    """Element matrices (E, 9, 9) of the rod's own second variation."""
    eye = np.eye(3)
    second = np.cross(tangents, first)
    stiffness = sum(
        k * np.einsum("eki,ekj->ekij", d, d)
        for k, d in zip(section, (tangents, first, second), strict=True)
    )
    pull = np.einsum("eki,eki->ek", forces, tangents)
    mixed = np.einsum("eki,ekj->ekij", forces, tangents)
    load = pull[..., None, None] * eye - 0.5 * (mixed + np.swapaxes(mixed, -1, -2))
    gyration = cross_matrix(moments)
    a = np.einsum("k,ka,kb,ekij->eaibj", WEIGHTS, _SLOPE, _SLOPE, stiffness)
    b = np.einsum("k,ka,kb,ekij->eaibj", WEIGHTS, _SLOPE, _SHAPE, gyration)
    c = np.einsum("k,ka,kb,ekij->eaibj", WEIGHTS, _SHAPE, _SHAPE, load)
    count = len(lengths)
    a, b, c = (part.reshape(count, 9, 9) for part in (a, b, c))
    h = lengths[:, None, None]
    return a / h - 0.5 * (b + np.swapaxes(b, 1, 2)) + c * h


def strain(m: np.ndarray, q: np.ndarray, section: np.ndarray) -> np.ndarray:
    """The Darboux vector u = sum of (m.d_i/k_i) d_i, its part along d_3 left as m's."""
    d = directors(q)
    k = np.array([section[1], section[2], 1.0])
    return d @ ((d.T @ m) / k)


def directors(q: np.ndarray) -> np.ndarray:
    """The matrix (3, 3) whose columns are d_1, d_2, d_3."""
    w, v = q[0], q[1:]
    return np.eye(3) + 2.0 * (w * cross_matrix(v) + cross_matrix(v) @ cross_matrix(v))


class SecondVariation:
    """The quadratic form of half a rod in the rotations (3 per node, 2 E + 1 nodes) and rho_C
    (3)."""

    def __init__(self, state: HalfRod, resolution: float | None = None) -> None:
        if resolution is not None:
            state = adapted(state, resolution)
        prm = state.parameters
        fields = evaluate_fields(state)
        lengths = state.lengths
        count, inner = state.eta.size, state.inner
        points = 3 * (2 * count + 1)
        size = points + 3
        self.centre = slice(points, points + 3)
        form = np.zeros((size, size))
        q = state.stages
        scalar, vector = q[..., :1], q[..., 1:]
        unit = np.array([1.0, 0.0, 0.0])
        across = np.cross(vector, unit)
        first = unit + 2.0 * (scalar * across + np.cross(vector, across))
        rod = (fields.tangents, first, fields.forces, fields.moments)
        blocks = _rod_form(*rod, lengths, prm.section)
        for e in range(count):
            own = slice(6 * e, 6 * e + 9)
            form[own, own] += blocks[e]
        # rho at the left end of every element and at its Gauss points: -int_s^{l/2} phi x d_3
        turn = -cross_matrix(fields.tangents)  # phi x d_3 = -[d_3 x] phi
        rate = np.einsum("ka,ekij->ekiaj", _SHAPE, turn).reshape(count, len(NODES), 3, 9)
        whole = lengths[:, None, None] * np.einsum("k,ekij->eij", WEIGHTS, rate)
        part = lengths[:, None, None, None] * np.einsum("lk,ekij->elij", MATRIX, rate)
        left = np.zeros((count + 1, 3, size))
        for e in range(count - 1, -1, -1):
            left[e] = left[e + 1]
            left[e, :, 6 * e : 6 * e + 9] -= whole[e]
        wet = np.repeat(left[:inner, None], len(NODES), axis=1)
        for e in range(inner):
            wet[e, :, :, 6 * e : 6 * e + 9] += part[e]
        wet[..., self.centre] -= np.eye(3)
        self._add_wall(form, state, fields.places[:inner], wet.reshape(-1, 3, size))
        self.constraint = left[0]
        self._add_meniscus(form, state, left[inner])
        self.form = 0.5 * (form + form.T)
        self.turns = state.weight != 0.0 or prm.anisotropic
        self.neutral = self._neutral_modes(state, fields, size)

    @staticmethod
    def _add_wall(form: np.ndarray, state: HalfRod, places: np.ndarray, eta: np.ndarray) -> None:
        prm = state.parameters
        w = places.reshape(-1, 3)
        r = np.linalg.norm(w, axis=1)
        gap = 1.0 + prm.wall_softness - 2.0 * r
        slope = 2.0 * prm.wall_strength / gap**2
        along = np.sqrt(np.maximum(4.0 * slope / gap, 0.0))
        across = np.sqrt(slope / r)
        core = core_radius(state)
        inside = r < core
        if inside.any():  # r = c (3 + 6 y - y^2)/8 there, y = (r/c)^2
            x = r[inside] / core
            gap = 1.0 + prm.wall_softness - 0.25 * core * (3.0 + 6.0 * x**2 - x**4)
            slope = 2.0 * prm.wall_strength / gap**2
            first, second = 0.5 * x * (3.0 - x**2), 1.5 * (1.0 - x**2) / core
            along[inside] = np.sqrt(slope * second + 4.0 * slope / gap * first**2)
            across[inside] = np.sqrt(slope * first / r[inside])
        unit = w / r[:, None]
        # factor of the Hessian: along e e^T + across (1 - e e^T), both positive
        factor = across[:, None, None] * np.eye(3)
        factor = factor + (along - across)[:, None, None] * np.einsum("gi,gj->gij", unit, unit)
        weight = np.sqrt((state.lengths[: state.inner, None] * WEIGHTS).ravel())
        rows = np.einsum("g,gij,gjn->gin", weight, factor, eta).reshape(-1, form.shape[0])
        form += rows.T @ rows

    def _add_meniscus(self, form: np.ndarray, state: HalfRod, rho: np.ndarray) -> None:
        """Meniscus terms, then b eliminated by w.(rho + b d_3 - rho_C) = 0."""
        prm = state.parameters
        y = state.nodes[state.inner]
        after, jacobian = np.empty(10), np.empty((10, 11))
        force = jump(y, float(state.scalars[5]), prm.meniscus_wall, after, jacobian)
        w = y[:3]
        q = y[3:7]
        t, m = np.empty(3), np.empty(3)
        tangent(q, t)
        moment(state.scalars[0], state.scalars[1], w, y[7:10], m)
        bend = np.cross(strain(m, q, prm.section), t)  # d_3'
        size = form.shape[0]
        eta = rho.copy()
        eta[:, self.centre] -= np.eye(3)
        slip = np.zeros(size)
        slip -= w @ eta / (w @ t)
        self.slip = slip
        moved = eta + np.outer(t, slip)
        node = slice(6 * state.inner, 6 * state.inner + 3)
        turning = np.zeros(size)
        turning[node] = np.cross(t, w)  # w . (phi x d_3) = phi . (d_3 x w)
        gradient = 2.0 * prm.wall_strength / prm.wall_softness**2 * w / np.linalg.norm(w)
        form += 2.0 * force * (moved.T @ moved + (w @ bend) * np.outer(slip, slip))
        form += 2.0 * force * (np.outer(slip, turning) + np.outer(turning, slip))
        pushed = gradient @ eta
        form += np.outer(slip, pushed) + np.outer(pushed, slip)
        form += (gradient @ t) * np.outer(slip, slip)

    def _neutral_modes(self, state: HalfRod, fields, size: int) -> np.ndarray:  # type: ignore[no-untyped-def]
        """Turning about the clamp axis and sliding along the rod (2, size)."""
        count = state.eta.size
        at = np.tile([0.0, 0.5], count)
        values = interpolate(state, fields, np.repeat(np.arange(count), 2), at)
        values = np.vstack([values, state.nodes[-1]])
        turn, slide = np.zeros(size), np.zeros(size)
        t, m = np.empty(3), np.empty(3)
        for i, y in enumerate(values):
            tangent(y[3:7], t)
            moment(state.scalars[0], state.scalars[1], y[:3], y[7:10], m)
            turn[3 * i : 3 * i + 3] = np.array([0.0, 0.0, 1.0]) - t
            slide[3 * i : 3 * i + 3] = (m @ t) * t - m
        centre = state.nodes[
            -1, 1
        ]  # r_C = (0, -w_y(l/2), 0): turning about the clamp axis moves it
        turn[self.centre] = np.array([centre, 0.0, 0.0])
        slide[self.centre] = np.array([0.0, 0.0, 1.0])
        return np.stack([turn, slide])

    def restricted(self, odd: bool, *, slides: bool = False) -> np.ndarray:
        """The form on flip-even or flip-odd variations: constraints, the turn and, unless the drop
        ``slides``, the slip penalised."""
        size = self.form.shape[0]
        keep = np.ones(size, dtype=bool)
        keep[self.centre.start - 3 : self.centre.start] = False  # phi = 0 at the clamp
        forbidden = [1] if odd else [0, 2]
        for axis in forbidden:
            keep[axis] = False
            keep[self.centre.start + axis] = False
        form = self.form[np.ix_(keep, keep)].copy()
        # rho(0) vanishes along the axes that this class forbids
        for axis in forbidden:
            row = self.constraint[axis][keep]
            form += PENALTY * np.outer(row, row)
        if odd:
            z = self.neutral[0][keep]
            if not self.turns:
                form += NEUTRAL_PENALTY * np.outer(z, z) / max(z @ z, 1e-300)
            if not slides:
                form += PENALTY * np.outer(self.slip[keep], self.slip[keep])
        self.kept_slip = self.slip[keep]
        return form

    def sliding_stiffness(self) -> float:
        """d^2E/dc^2 of sliding by c, everything else relaxed."""
        form = self.restricted(True, slides=True)
        return float(2.0 / (self.kept_slip @ np.linalg.solve(form, self.kept_slip)))


def dense_modes(state: HalfRod, resolution: float | None = None) -> tuple[int, int]:
    """Numbers of unstable flip-even and flip-odd modes, the drop held in its place along the rod."""
    variation = SecondVariation(state, resolution)
    return _negative(variation.restricted(False)), _negative(variation.restricted(True))


def _negative(form: np.ndarray) -> int:
    """Number of negative eigenvalues, by Sylvester's law from LAPACK's symmetric factorisation.

    A 2 x 2 pivot of Bunch and Kaufman's pivoting is indefinite: one negative eigenvalue each.
    """
    factor, pivots, info = dsytrf(form, lower=1)
    if info < 0:
        raise ValueError(f"dsytrf: bad argument {-info}")
    single = pivots > 0
    return int(np.count_nonzero(np.diag(factor)[single] < 0.0) + np.count_nonzero(~single) // 2)
