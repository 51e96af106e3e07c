"""Predict the state at the control's next value from the branch's slope and the state before."""

from __future__ import annotations

from derod.equilibrium.control import Control
from derod.equilibrium.measured import Measured
from derod.equilibrium.system import System
from derod.pushing.prediction import extrapolate
from derod.rod.state import State

LONGEST_LOOK_AHEAD = 2.5  # of the last increment, for more than the first order
ORDERS = (3, 2, 1)  # tried in turn, where a state before is near enough


def predict(
    system: System, control: Control, here: Measured, before: Measured | None, target: float
) -> State | None:
    """Return a guess of the state at the control's value ``target``, or None where none is sound.

    Third order where ``before``, the state before on the same branch, is near enough, else second, else
    first; along the wall's curve where a straight prediction runs into it. Near a joint or a fold the slope
    is steep, and only a shorter step has a sound guess (``pushing.prediction``).
    """
    state = here.state
    h = target - here.control_value
    old = here if before is None else before
    back = old.control_value - here.control_value
    near = back != 0.0 and abs(h / back) <= LONGEST_LOOK_AHEAD
    counted_alike = (
        state.width == state.dimension + 1
    )  # angles count from a frame of each state's own
    orders = (1,) if not near else ORDERS if counted_alike else ORDERS[1:]
    guess = state.copy()
    for follow_wall in (False, True):
        for order in orders:
            if extrapolate(
                state.physics, system.room.kin, state.q, state.b, here.slope_q, here.slope_b, h,
                old.state.q, old.state.b, old.slope_q, old.slope_b, back, order,
                follow_wall, guess.q, guess.b,
            ):  # fmt: skip
                control.set(guess, target)
                guess.read_end()
                return guess
    return None
