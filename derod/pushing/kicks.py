"""Leave an unstable equilibrium: a kick along its lowest mode, and what decides the side.

The side is downhill where the state is off the saddle far enough to have one. At a saddle the seed decides;
where the mode breaks a symmetry that the state has, the two sides are mirror images and their minima have
equal energies.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from derod.equilibrium.stability import lowest_mode
from derod.equilibrium.symmetry import asymmetric
from derod.equilibrium.system import System
from derod.rod.state import State, in_space
from derod.rod.unknowns import F_A

SLOPED = 0.5  # of the kick's gain by curvature: a slope that gives more than this decides the side
SYMMETRIC = 1e-6  # relative, of what a symmetry must leave of a state, and take from a mode
LEAST = 1e-8  # D, of a kick
GAP_LEFT = 0.2  # of the wall's gap that a kick must leave


@dataclass(frozen=True, slots=True)
class Kick:
    """A state moved off a saddle."""

    state: State
    eigenvalue: float  # the lowest, K0/D^4
    sloped: bool  # whether the way was downhill already; else the seed decided the side
    mirror: bool  # whether the other side's is a mirror image


def kick(
    system: System, state: State, amplitude: float, start: np.ndarray, side: float = 1.0
) -> Kick:
    """Move ``state`` by ``amplitude`` (D) along its lowest mode, and onto its constraints.

    ``start`` has the shape of q; it begins the search for the mode, and with ``side``, 1 or -1, decides where
    nothing else does. The amplitude is halved until the energy falls.
    """
    value, mode_q, mode_b = lowest_mode(system, state, start)
    system.gradient(state)
    energy = system.energies(state).potential
    d = system.dimension
    slope = float(np.sum(system.room.r[1:-1, :d] * mode_q[1:-1, :d]))
    slope += float(np.sum(system.room.r[1:, d + 1 :] * mode_q[1:, d + 1 : state.width]))
    slope += float(system.room.rb[: F_A + d] @ mode_b[: F_A + d])
    sloped = abs(slope) > SLOPED * 0.5 * abs(value) * amplitude
    sign = -np.sign(slope) if sloped else side
    gap = system.wall_gap(state)
    while amplitude > LEAST:
        moved = state.copy()
        moved.q += sign * amplitude * mode_q
        moved.b += sign * amplitude * mode_b
        put = onto_constraints(system, moved, gap, 2 * abs(value))
        if put and system.energies(moved).potential < energy:
            break
        amplitude *= 0.5
    else:
        moved = state.copy()
    return Kick(
        moved,
        value,
        bool(sloped),
        breaks_a_symmetry(state, mode_q, state.physics.end_rotation - state.holonomy)
        and not asymmetric(state.physics),
    )


def onto_constraints(system: System, moved: State, gap: float, shift: float) -> bool:
    """Put a kicked state onto its constraints (``System.project``); False where that fails.

    ``gap`` (D) is the wall's before the kick; one that takes too much of it fails too.
    """
    return system.wall_gap(moved) > GAP_LEFT * gap and system.project(moved, shift)


def breaks_a_symmetry(state: State, mode_q: np.ndarray, twist: float) -> bool:
    """Return whether the state is its own image under a symmetry that turns the mode into minus itself.

    Symmetries of a rod between clamps of one axis: the flip about a line across it, which runs the rod from
    its other end; and, where there is no twist that they would reverse, mirrors at planes through the axis or
    across it, and the point reflection.
    """
    d = state.dimension
    x, u = in_space(state.q[:, :d]), in_space(mode_q[:, :d])
    middle = np.array([0.0, 0.0, 0.5 * x[-1, 2]])
    x = x - middle
    frame = principal_frame(x)
    x, u = x @ frame, u @ frame
    size, length = np.abs(u).max(), np.abs(x).max()
    reverse = slice(None, None, -1)
    flips = [((-1, 1, -1), reverse), ((1, -1, -1), reverse)]
    mirrors = [((-1, 1, 1), slice(None)), ((1, -1, 1), slice(None))]
    mirrors += [((-1, -1, -1), reverse), ((1, 1, -1), reverse)]
    for signs, order in flips + (mirrors if abs(twist) < SYMMETRIC else []):
        image = np.array(signs, dtype=float)
        own = np.abs(image * x[order] - x).max() < SYMMETRIC * length
        odd = np.abs(image * u[order] + u).max() < 1e-3 * size
        if own and odd:
            return True
    return False


def principal_frame(x: np.ndarray) -> np.ndarray:
    """Return the turn about the axis, (3, 3), that puts the rod's lateral extents on x and y."""
    moment = x[:, :2].T @ x[:, :2]
    _, vectors = np.linalg.eigh(moment)
    frame = np.eye(3)
    frame[:2, :2] = vectors
    return frame
