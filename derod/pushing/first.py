"""The first state of a push: the straight rod, bent a little, and settled."""

from __future__ import annotations

from typing import Any

from derod.equilibrium.system import System
from derod.pushing.controls import CONTROLS
from derod.pushing.frames import Outcome
from derod.pushing.guess import bent_guess
from derod.pushing.increments import OUTER_LEAST, Increment, Increments
from derod.pushing.stuck import Stuck, outcome_of
from derod.scene import Scene
from derod.scene.program import SHORTENING


def first_physics(system: System, scene: Scene, slides: bool) -> Any:
    """Return the constants of the first state."""
    physics = system.physics._replace(slides=slides)
    push = scene.push
    if push.control == SHORTENING:
        return physics
    unit = system.bending ** CONTROLS[push.control].power
    return physics._replace(**{push.control: push.start / unit})


def first_state(work: Increments, scene: Scene, physics: Any, end_shortening: float) -> Increment:
    """Settle the bent guess, downhill where its end slides or nothing is found beside it.

    Raises Stuck.
    """
    system = work.system
    side = -1.0 if scene.push.bend == "up" else 1.0
    guess = bent_guess(system, physics, end_shortening, side)
    solution = None if physics.slides else work.relax(guess)
    if solution is None or not solution.converged:
        solution = work.descender().descend(guess).solution
    if not solution.converged:
        if physics.slides and system.outer_length(solution.state) < 10 * OUTER_LEAST:
            raise Stuck(
                Outcome.ROD_RAN_OUT,
                "no stable state at the start: under this end tension the rod runs in until the "
                "outer rod has run out",
            )
        raise Stuck(
            outcome_of(solution.outcome),
            f"no first equilibrium from the bent guess: {solution.message}",
        )
    here = work.measure(solution.state)
    return Increment(here, solution.iterations, solution.residual, smooth=False)
