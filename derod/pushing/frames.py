"""What a push hands to those who watch it: frames, events and the final outcome.

One frame is one settled increment. The HDF5 writer, the progress bar and the rerun stream are all
observers: they receive the same frames and never act on the push.
Lengths are in D, forces in K0/D^2, energies in K0/D, angles in radians, times in seconds.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from enum import StrEnum
from typing import TYPE_CHECKING, Protocol, runtime_checkable

import numpy as np

if TYPE_CHECKING:
    from derod.equilibrium.loop import Report
    from derod.rod.state import State
    from derod.scene import Scene


@dataclass(frozen=True, slots=True)
class Frame:
    """One settled increment: a ``rows.ROW`` and the fields that drawing and resuming need."""

    row: np.void  # of dtype ``rows.ROW``
    positions: np.ndarray  # (N+1, 3), nodes, D
    arc_length: np.ndarray  # (N+1,), of the nodes, D
    drop_center: np.ndarray  # (3,), D
    edge_tension: np.ndarray  # (N,), K0/D^2
    edge_frame: np.ndarray | None = None
    """(N, 7), of a section with directions: the angle (rad) of d_1 about each edge, and the tangent and the
    director from which it is counted (``derod.rod.frames``)."""


@dataclass(frozen=True, slots=True)
class Event:
    """Something that happened between two frames.

    kind: "instability" (a kick along an unstable mode and the descent from it), "snap" (no
    neighbouring state: descent over a fold), "halving" (an increment did not converge, or its
    energy did not balance, and is retried), "turn" (a turning point of push.stop), "coarse" (a warning:
    the mesh is too coarse for the coil).
    """

    increment: int  # the frame that follows it
    kind: str
    end_shortening: float
    energy_before: float  # E_hat, nan where it has no meaning
    energy_after: float
    message: str
    control_value: float = math.nan
    """Of what pushes, in its unit: where a branch ends or loses its stability, located if
    ``push.locate`` says so."""


class Outcome(StrEnum):
    """How a push ended."""

    COMPLETED = "completed"
    ROD_RAN_OUT = "rod_ran_out"
    NOT_CONVERGED = "not_converged"
    DIVERGED = "diverged"
    OUT_OF_BALANCE = "out_of_balance"  # only states were found that gain energy over the end's work
    INTERRUPTED = "interrupted"
    RECORD_FAILED = "record_failed"


@dataclass(frozen=True, slots=True)
class Ending:
    """The outcome of a push, and where and why it ended."""

    outcome: Outcome
    message: str
    end_shortening: float
    compiling: float = field(default=0.0, compare=False)
    """Seconds spent on compiling kernels for it, which no ``wall_time`` counts."""


class Observer(Protocol):
    """Watches a push. Methods are called in the order start, (event | frame)*, finish."""

    def start(self, scene: Scene, first_increment: int) -> None:
        """Begin; ``first_increment`` is 0, or the number of frames a resumed run already has."""

    def event(self, event: Event) -> None:
        """An event; the frame with index ``event.increment`` follows, if the push gets there."""

    def frame(self, frame: Frame) -> None:
        """A settled increment. When this returns, the writer has committed it."""

    def finish(self, ending: Ending) -> None:
        """The push is over, however it ended."""


@runtime_checkable
class RelaxationObserver(Protocol):
    """An observer that also watches the steps inside an increment."""

    def relaxation(self, increment: int, iteration: int, state: State, report: Report) -> None:
        """A step toward the frame ``increment``, which may need several relaxations.

        The state is the relaxation's own: copy what shall be kept. Its forces, and the report's, are in units
        of the scene's bending stiffness over D^2.
        """
