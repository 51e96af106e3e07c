"""When a push cannot go on."""

from __future__ import annotations

from derod.equilibrium.loop import Outcome as RelaxOutcome
from derod.pushing.frames import Outcome


class Stuck(Exception):  # noqa: N818 - an ending, not an error
    """The push cannot go on."""

    def __init__(self, outcome: Outcome, message: str) -> None:
        super().__init__(message)
        self.outcome = outcome


def outcome_of(outcome: RelaxOutcome | None) -> Outcome:
    """Return the push's outcome for a relaxation that did not converge; None: it gained energy."""
    kinds = {None: Outcome.OUT_OF_BALANCE, RelaxOutcome.DIVERGED: Outcome.DIVERGED}
    return kinds.get(outcome, Outcome.NOT_CONVERGED)
