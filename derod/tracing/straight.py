r"""The straight rod: its states under end tensions, where they buckle, and the first point beyond.

An inextensible rod is straight at delta = 0 under any tension T, so that the trivial path is one in T:
states of a rod whose end slides under the dead load T. Where the count changes the rod buckles; the
critical eigenvalue is nearly linear in T, and a secant finds its zero. In space the modes of an isotropic
rod come in pairs, turned by a quarter about the axis: the one in the y-z plane is taken.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from derod.equilibrium.implicit import Implicit
from derod.equilibrium.loop import relax
from derod.equilibrium.system import System
from derod.errors import DerodError
from derod.rod.arrays import new_q
from derod.rod.state import State
from derod.rod.unknowns import BORDER, ETA, F_A, S_A, S_B, X_C
from derod.tracing.arc import Arc, Point, weighed
from derod.tracing.bordered import Vector
from derod.tracing.critical import nearest_modes

SHARES = 60  # of the range of tensions, looked at one by one
LOOKS, CLOSE = 30, 1e-11  # of a secant, at most; relative change of the tension in its last step
PLANAR = 1e-7  # relative, of a mode's part out of its plane that is rounding
LEAPS = (0.05, 0.1, 0.02, 0.01, 0.2)  # D in the path's norm


class StraightError(DerodError):
    """A straight rod that cannot be settled."""


@dataclass(frozen=True, slots=True)
class Buckling:
    """Where the straight rod buckles."""

    tension: float  # K/D^2
    mode: Vector  # M-orthonormal
    change: int  # of the count, as the tension falls
    state: State  # straight, its end free to slide


def straight_state(system: System, tension: float) -> State:
    """Return the straight rod under a dead load ``tension`` (K/D^2), settled. Raises StraightError."""
    d = system.dimension
    physics = system.physics._replace(slides=True, end_tension=tension)
    state = State(new_q(system.edges, physics), np.zeros(BORDER + d), 0.0, 0.0, physics)
    middle = 0.5 * physics.length
    if physics.drop:
        state.b[S_A], state.b[S_B] = middle - 0.5, middle + 0.5
        state.b[X_C + d - 1] = middle
        state.b[F_A + d : ETA + d] = physics.capillary_force
    state.q[:, d - 1] = system.arc_length(state)
    state.q[1:, d] = tension
    if physics.drop:
        kin = system.room.kin
        state.q[1 + kin.node_a : 1 + kin.node_b, d] -= physics.capillary_force
    state.holonomy = 0.0
    found = relax(Implicit(), system, state)
    if not found.converged:
        raise StraightError(f"the straight rod under the end tension {tension:g}: {found.message}")
    return found.state


def bucklings(system: System, most: int, least: float | None = None) -> list[Buckling]:
    """Return the first ``most`` buckling points of the straight rod, the tension falling from stability.

    No tension below ``least`` (K/D^2) is looked at; by default that is 4 times Euler's load of the whole
    rod per mode wanted, below zero.
    """
    physics = system.physics
    euler = 4 * math.pi**2 / physics.length**2
    high = physics.capillary_force if physics.drop else euler
    low = -euler * (most + 1) ** 2 if least is None else least
    step = (high - low) / SHARES
    if physics.drop:
        step = min(step, physics.capillary_force / SHARES)
    found: list[Buckling] = []
    tension = high
    count = count_at(system, tension)
    while tension > low and len(found) < most:
        below = max(low, tension - step)
        there = count_at(system, below)
        found += between(system, (tension, count), (below, there))
        tension, count = below, there
    return found[:most]


def count_at(system: System, tension: float) -> int:
    """Return the number of unstable modes of the straight rod."""
    return system.linearise(straight_state(system, tension))


def between(system: System, high: tuple[float, int], low: tuple[float, int]) -> list[Buckling]:
    """Return the buckling points between two tensions, the higher one's first."""
    if high[1] == low[1]:
        return []
    pair = 2 if system.dimension == 3 else 1
    if abs(low[1] - high[1]) > pair and high[0] - low[0] > 1e-6 * (1 + abs(high[0])):
        middle = 0.5 * (high[0] + low[0])
        split = (middle, count_at(system, middle))
        return [*between(system, high, split), *between(system, split, low)]
    return [refined(system, high, low)]


def refined(system: System, high: tuple[float, int], low: tuple[float, int]) -> Buckling:
    """Return the one buckling point between two tensions: the zero of the critical eigenvalue."""

    a, b = high[0], low[0]  # the counts there bracket the point
    fa, fb = critical(system, a, above=True)[0], critical(system, b, above=False)[0]
    tension = 0.5 * (a + b)
    for look in range(LOOKS):
        before = tension
        tension = a - fa * (b - a) / (fb - fa) if fa > 0 > fb else 0.5 * (a + b)
        if look and abs(tension - before) <= CLOSE * (1 + abs(tension)):
            break
        if count_at(system, tension) <= high[1]:
            f = critical(system, tension, above=True)[0]
            fb *= 0.5 if abs(f) > 0.1 * abs(fa) else 1.0
            a, fa = tension, f
        else:
            f = critical(system, tension, above=False)[0]
            fa *= 0.5 if abs(f) > 0.1 * abs(fb) else 1.0
            b, fb = tension, f
    _, state, modes = critical(system, tension, above=abs(fa) < abs(fb))
    return Buckling(tension, in_its_plane(system, modes), low[1] - high[1], state)


def critical(system: System, tension: float, *, above: bool) -> tuple[float, State, list[Vector]]:
    """Return the eigenvalue nearest to zero on its stable side (``above``) or the other; 0 where none is
    seen.

    With the straight state, and the pair of modes nearest to zero.
    """
    state = straight_state(system, tension)
    values, modes = nearest_modes(system, state, 8)
    side = values[values > 0] if above else values[values < 0]
    return (float(side[0]) if side.size else 0.0), state, modes[:2]


def in_its_plane(system: System, modes: list[Vector]) -> Vector:
    """Return the mode of a pair that leaves the y-z plane least, and not at all where that is rounding."""
    if system.dimension == 2:
        return modes[0]
    out = np.array([[np.vdot(m.rows[:, 0], n.rows[:, 0]) for n in modes] for m in modes])
    _, mix = np.linalg.eigh(out)
    first, second = mix[:, 0]
    mode = modes[0].times(first) + modes[1].times(second)
    if np.abs(mode.rows[:, 0]).max() < PLANAR * np.abs(mode.rows[:, 1]).max():
        mode.rows[:, 0] = 0.0
        mode.border[X_C] = 0.0
    middle = mode.rows[:, 1][np.argmax(np.abs(mode.rows[:, 1]))]
    return mode.times(math.copysign(1.0, middle))


def buckled(arc: Arc, buckling: Buckling, side: float = 1.0) -> Point | None:
    """Return the first point of the path that leaves the straight rod along its mode, or None."""
    system, control = arc.system, arc.control
    d = system.dimension
    base = buckling.state
    slides = control.name == "end_tension"
    mode = buckling.mode.times(side)
    system.gradient(base)
    rest = system.room.kin.rest[1:-1].copy()
    weight = arc.metric(base)
    for leap in LEAPS:
        guess = base.copy()
        guess.q[1:, : guess.width] += leap * mode.rows
        guess.b += leap * mode.border[: guess.b.size]
        across = np.diff(guess.q[:, : d - 1], axis=0)
        along = np.sqrt(np.maximum(rest**2 - np.sum(across**2, axis=1), 0.0))
        guess.q[1:, d - 1] = np.cumsum(along)
        shortened = float(system.physics.length - guess.q[-1, d - 1])
        if system.physics.drop:
            guess.b[X_C + d - 1] = 0.5 * guess.q[-1, d - 1]
        if not slides:
            guess.physics = guess.physics._replace(slides=False, end_tension=0.0)
            guess.clamp_at(shortened)
        guess.end_shortening = shortened
        if not slides or shortened > 0:
            direction = weighed(weight, mode)
            done = arc.correct(guess, direction, 0.0, leap)
            found = None if done is None else arc.point(done[0], direction, 0.0)
            if found is not None:
                return found
    return None
