"""Fields along a half rod: at its Gauss points, and between its nodes."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np
from numba import njit

from derod.branches.half_rod.element import PARAMETERS, stages
from derod.branches.half_rod.gauss import NODES, STAGES
from derod.branches.half_rod.section import bending_strain, director
from derod.branches.half_rod.state import HalfRod


@dataclass(frozen=True)
class Fields:
    """Quantities at the Gauss points: (E, m, 3) except ``rates`` (E, m, 10), d/ds of the node
    state."""

    tangents: np.ndarray
    places: np.ndarray  # w = r - r_C
    forces: np.ndarray  # n
    moments: np.ndarray  # m
    rates: np.ndarray
    gap: float


@njit(cache=True, error_model="numpy")
def _fields(nodes, Q, h, inner, p, section, strength, softness, D, W, N, M, rates):  # type: ignore[no-untyped-def]
    """Run ``stages`` over all elements; returns the least gap."""
    m = Q.shape[1]
    G = np.zeros((m, 3))
    H = np.zeros((m, 3, 3))
    P = np.empty((m, 4))
    least = 1.0
    for e in range(h.size):
        wet = e < inner
        y = nodes[e if wet else e + 1]
        rest = (D[e], W[e], G, H, N[e], M[e], P)
        gap = stages(y, Q[e], h[e], p, section, strength, softness, wet, *rest)
        least = min(least, gap)
        for k in range(m):
            for i in range(3):
                rates[e, k, i] = D[e, k, i]
                rates[e, k, 7 + i] = G[k, i] if wet else 0.0
            for i in range(4):
                rates[e, k, 3 + i] = P[k, i]
    return least


def evaluate_fields(state: HalfRod) -> Fields:
    """All fields at the Gauss points of a state."""
    prm = state.parameters
    shape = (state.eta.size, STAGES, 3)
    D, W, N, M = (np.empty(shape) for _ in range(4))
    rates = np.empty((*shape[:2], 10))
    gap = _fields(
        state.nodes,
        state.stages,
        state.lengths,
        state.inner,
        state.scalars[:PARAMETERS],
        prm.section,
        prm.wall_strength,
        prm.wall_softness,
        D,
        W,
        N,
        M,
        rates,
    )
    return Fields(D, W, N, M, rates, gap)


@njit(cache=True, error_model="numpy")
def _section_fields(Q, M, section, U, first):  # type: ignore[no-untyped-def]
    for e in range(Q.shape[0]):
        for k in range(Q.shape[1]):
            bending_strain(M[e, k], section, Q[e, k], U[e, k])
            director(Q[e, k], 1, first[e, k])


def bending_strains(state: HalfRod, fields: Fields) -> np.ndarray:
    """u up to a multiple of d_3 at the Gauss points (E, m, 3), d_3' = u x d_3; m itself where K1 = K2."""
    if not state.parameters.anisotropic:
        return fields.moments
    return section_fields(state, fields)[0]


def section_fields(state: HalfRod, fields: Fields) -> tuple[np.ndarray, np.ndarray]:
    """Bending strains and d_1 at the Gauss points, each (E, m, 3)."""
    strains, first = np.empty_like(fields.moments), np.empty_like(fields.moments)
    _section_fields(state.stages, fields.moments, state.parameters.section, strains, first)
    return strains, first


@cache
def _primitives() -> np.ndarray:
    """Coefficients (m, m+1), lowest first, of the integrals of the Lagrange basis through the
    Gauss points."""
    out = np.zeros((STAGES, STAGES + 1))
    for k in range(STAGES):
        others = np.delete(NODES, k)
        basis = np.poly1d(others, r=True) / np.prod(NODES[k] - others)
        out[k] = basis.integ().coeffs[::-1]
    return out


def interpolate(state: HalfRod, fields: Fields, element: np.ndarray, at: np.ndarray) -> np.ndarray:
    """The collocation polynomial (k, 10) in the elements (k,) at fractions ``at`` (k,) of them."""
    powers = at[:, None] ** np.arange(STAGES + 1)
    weights = powers @ _primitives().T
    left = element + (element >= state.inner)
    h = state.lengths[element]
    return state.nodes[left] + h[:, None] * np.einsum("kj,kji->ki", weights, fields.rates[element])
