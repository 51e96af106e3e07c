"""What the observers of a push are told: frames, and events between them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from derod.algebra import compiling
from derod.equilibrium.loop import Report
from derod.equilibrium.measured import Measured
from derod.equilibrium.system import System
from derod.pushing.columns import Settled
from derod.pushing.encode import encode
from derod.pushing.frames import Event, Frame, Observer, RelaxationObserver
from derod.rod.state import State
from derod.scene.resolution import COARSE, edges_enough


class Telling:
    """Hands frames and events to the observers of one push, in order."""

    def __init__(self, system: System, observers: Sequence[Observer]) -> None:
        self.system = system
        self.observers = observers
        self.watchers = [o for o in observers if isinstance(o, RelaxationObserver)]
        self.count = 0
        self.clock = compiling.clock()
        self.recording = True
        self.turning = 0.0  # rad, the largest at a node of the last row

    def go_on(self, row: np.void, count: int) -> None:
        """Take up a run after its last row."""
        self.count = count
        self.turning = float(row["turning_angle"])
        self.clock -= float(row["wall_time"])

    def elapsed(self) -> float:
        """Return the seconds since the push began, without those of compilation."""
        return compiling.clock() - self.clock

    def frame(self, here: Measured, settled: Settled) -> Frame:
        """Hand on a settled increment; warn where the mesh gets too coarse for it."""
        frame = encode(self.system, here, settled)
        if here.turning > COARSE >= self.turning:
            self.event(
                "coarse",
                here.state.end_shortening,
                f"the rod turns by {here.turning:.3g} rad at a node: the mesh is too coarse for the "
                f"coil; {edges_enough(self.system.edges, here.turning)} edges would do",
            )
        self.turning = here.turning
        for observer in self.observers:
            observer.frame(frame)
        self.count += 1
        return frame

    def event(
        self,
        kind: str,
        end_shortening: float,
        message: str,
        before: float = np.nan,
        after: float = np.nan,
        value: float = np.nan,
    ) -> None:
        """Hand on an event; ``before`` and ``after`` are E_hat, K/D, ``value`` the control's, as in files."""
        if not self.recording:
            return
        unit = self.system.bending
        energies = (before * unit, after * unit)
        event = Event(self.count, kind, end_shortening, *energies, message, value)
        for observer in self.observers:
            observer.event(event)

    def step(self, iteration: int, state: State, report: Report) -> None:
        """Hand on a step of a relaxation to those who want to see every one."""
        for observer in self.watchers:
            observer.relaxation(self.count, iteration, state, report)
