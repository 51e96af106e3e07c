"""Watch every descent of a push: does a step go uphill?"""

from __future__ import annotations

from derod.equilibrium.loop import Report
from derod.equilibrium.system import System
from derod.pushing.frames import Ending, Event, Frame
from derod.rod.state import State
from derod.scene import Scene

ROUNDING = 1e-10  # of the energies' size


class Descents:
    """An observer that counts the accepted steps of descents, and those that raise E_tot."""

    def __init__(self) -> None:
        self.steps = 0
        self.uphill = 0
        self._energy: float | None = None

    def start(self, scene: Scene, first_increment: int) -> None:
        """Make room to measure energies in."""
        self._system = System(scene)

    def event(self, event: Event) -> None:
        """Nothing to do."""

    def frame(self, frame: Frame) -> None:
        """Nothing to do."""

    def finish(self, ending: Ending) -> None:
        """Nothing to do."""

    def relaxation(self, increment: int, iteration: int, state: State, report: Report) -> None:
        """Hold the energy of a descending step against the one before in the same descent."""
        if not report.descending:
            self._energy = None
            return
        before = self._energy if iteration > 0 else None
        self._energy = self._system.energies(state).total
        if before is not None:
            self.steps += 1
            self.uphill += self._energy > before + ROUNDING * (1 + abs(before))
