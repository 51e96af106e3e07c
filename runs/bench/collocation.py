"""scipy's solve_bvp on the clamped-clamped elastica: collocation of fourth order, the mesh its own.

    theta' = kappa,  kappa' = -P sin theta - Q cos theta,  x' = cos theta,  y' = sin theta

with P and Q unknown and theta, x, y given at both ends. It is handed a shape to begin with, a cosine of
about the right height, where the rods start straight.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.integrate import solve_bvp

from bench.elastica import SHORTENING

HEIGHT = 0.25  # L, of the guess


class Settings(NamedTuple):
    """What is scanned."""

    nodes: int
    tolerance: float = 1e-3
    jacobian: bool = True

    def __str__(self) -> str:
        return f"tol {self.tolerance:.0e}, {'own' if self.jacobian else 'numerical'} Jacobian"


SCAN = [
    Settings(nodes, tolerance, jacobian)
    for jacobian in (True, False)
    for tolerance in (1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6)
    for nodes in (7, 11, 15, 21, 31, 41, 61)
]


class Answer(NamedTuple):
    """What it settled into."""

    iterations: int
    tension: float  # K/L^2
    height: float  # L


def right(s: np.ndarray, u: np.ndarray, p: np.ndarray) -> np.ndarray:
    """Return u' of u = (theta, kappa, x, y)."""
    sine, cosine = np.sin(u[0]), np.cos(u[0])
    return np.array([u[1], -p[0] * sine - p[1] * cosine, cosine, sine])


def slopes(s: np.ndarray, u: np.ndarray, p: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the derivatives of u' by u and by p."""
    sine, cosine = np.sin(u[0]), np.cos(u[0])
    by_u, by_p = np.zeros((4, 4, s.size)), np.zeros((4, 2, s.size))
    by_u[0, 1] = 1.0
    by_u[1, 0] = -p[0] * cosine + p[1] * sine
    by_u[2, 0], by_u[3, 0] = -sine, cosine
    by_p[1, 0], by_p[1, 1] = -sine, -cosine
    return by_u, by_p


def ends(a: np.ndarray, b: np.ndarray, p: np.ndarray) -> np.ndarray:
    """Return what is zero at both ends."""
    return np.array([a[0], a[2], a[3], b[0], b[2] - (1 - SHORTENING), b[3]])


def solve(settings: Settings) -> Answer | None:
    """Solve from the guess; None where it does not converge."""
    s = np.linspace(0, 1, settings.nodes)
    slope = HEIGHT * np.pi * np.sin(2 * np.pi * s)
    guess = np.array([
        slope, 2 * HEIGHT * np.pi**2 * np.cos(2 * np.pi * s), (1 - SHORTENING) * s,
        0.5 * HEIGHT * (1 - np.cos(2 * np.pi * s)),
    ])  # fmt: skip
    found = solve_bvp(
        right, ends, s, guess, p=[40.0, 0.0], tol=settings.tolerance,
        fun_jac=slopes if settings.jacobian else None,
    )  # fmt: skip
    if not found.success:
        return None
    return Answer(found.niter, -float(found.p[0]), float(abs(found.sol(0.5)[3])))
