"""Predict the state at the next end-shortening from the branch's slope and the state before."""

from __future__ import annotations

from derod.stability import Equilibrium
from derod.state import State
from derod.system import System

LONGEST_LOOK_AHEAD = 2.5  # of the last increment, for the second order
FARTHEST = 0.25  # D a node may be predicted to move, or the prediction is not trusted


def predict(
    system: System, state: State, here: Equilibrium, before: State | None, target: float
) -> State:
    """Return a guess of the state at end-shortening ``target`` (D).

    Second order where ``before``, the state before on the same branch, is near enough; first order
    otherwise; the state itself with its clamp moved where the slope would carry it out of the wall or
    too far (at a fold the slope is infinite).
    """
    h = target - state.end_shortening
    for bend in (True, False):
        if bend and before is None:
            continue
        guess = state.copy()
        guess.q += h * here.slope_q
        guess.b += h * here.slope_b
        if bend and before is not None:
            back = before.end_shortening - state.end_shortening
            ratio = h / back
            if not abs(ratio) <= LONGEST_LOOK_AHEAD:
                continue
            # before = state + back slope + back^2 curve / 2
            guess.q += ratio**2 * (before.q - state.q - back * here.slope_q)
            guess.b += ratio**2 * (before.b - state.b - back * here.slope_b)
        guess.clamp_at(target, system.physics.length)
        d = state.dimension
        moved = abs(guess.q[:, :d] - state.q[:, :d]).max()
        if moved < FARTHEST and system.wall_gap(guess) > 0.2 * system.wall_gap(state):
            return guess
    guess = state.copy()
    guess.clamp_at(target, system.physics.length)
    return guess
