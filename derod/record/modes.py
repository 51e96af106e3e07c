"""The softest modes of a recorded increment: lowest eigenvalues of the Hessian on the constraints.

What they are, and in which norm, is in ``derod.equilibrium.eigen``; how they stand to the state's symmetries
in ``derod.equilibrium.symmetry``. Turning about the clamp axis and sliding the drop along the rod are named
and left out: the first is neutral on every state of an isotropic rod whose drop has no weight, the second
is pinned, as in the count of unstable modes, and has a stiffness of its own.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from derod.equilibrium import eigen, stability, symmetry
from derod.equilibrium.eigen import ModesError, NotConvergedError
from derod.equilibrium.system import System
from derod.equilibrium.turning import turns_freely
from derod.pushing.encode import decode
from derod.rod.state import State, in_space
from derod.rod.unknowns import S_A, S_B, X_C
from derod.scene.program import legs

if TYPE_CHECKING:
    from derod.record.run import BaseRun

SPARE = 2  # modes more than asked for: those of one eigenvalue belong together

__all__ = ["Modes", "ModesError", "NotConvergedError", "modes", "state_of"]


@dataclass(frozen=True, repr=False)
class Modes:
    """The k lowest modes of an increment, softest first; negative eigenvalues are unstable."""

    eigenvalues: np.ndarray
    """(k,), K0/D^4."""
    shapes: np.ndarray
    """Displacements of the nodes, (k, N+1, 3); the largest component of each is 1."""
    menisci: np.ndarray
    """Changes of s_A and s_B, (k, 2)."""
    drop: np.ndarray
    """Displacements of the drop's centre, (k, 3)."""
    flip: tuple[str, ...]
    """"even" or "odd" under the flip that runs the rod from its other end, "" where the state has none."""
    plane: tuple[str, ...]
    """"in" or "out" of the plane that the rod lies in, "" where it lies in none."""
    turns_freely: bool
    """Whether turning about the clamp axis is neutral: it is left out then, else it is among the modes."""
    sliding_stiffness: float
    """k = d^2E/dc^2 (K0/D^3) of sliding the drop by c, which is left out; infinite without a drop."""

    def __len__(self) -> int:
        return len(self.eigenvalues)

    def __repr__(self) -> str:
        values = ", ".join(f"{value:.6g}" for value in self.eigenvalues)
        return f"<{len(self)} modes: eigenvalues {values} K0/D^4>"


def state_of(run: BaseRun, i: int, system: System | None = None) -> tuple[System, State]:
    """Return the system of a run's scene, made here if None, and an increment's state in the rod's units."""
    system, frame = System(run.scene) if system is None else system, run.frame_at(i)
    slides = legs(run.scene)[int(frame.row["segment"])].slides
    return system, decode(system, frame, slides=slides)


def modes(run: BaseRun, i: int, k: int) -> Modes:
    """See ``BaseRun.modes``."""
    system, state = state_of(run, i)
    try:
        return modes_at(system, state, k)
    except NotConvergedError as error:
        raise NotConvergedError(f"increment {i}: {error}") from error
    except ModesError as error:
        raise ModesError(f"increment {i}: {error}") from error


def modes_at(system: System, state: State, k: int) -> Modes:
    """Return the ``k`` lowest modes at a settled state."""
    most = eigen.most_modes(system, state)
    pairs = eigen.lowest(system, state, min(k + SPARE, most) if 1 <= k <= most else k)
    rest = system.room.kin.rest
    weight = 0.5 * (rest[:-1] + rest[1:])
    pairs = symmetry.aligned(state, pairs, weight)
    flip, plane = symmetry.parities(state, pairs, weight)
    system.linearise(state)  # not shifted, the pin's entry tells the stiffness of sliding
    d = system.dimension
    nodes, borders = pairs.q[:k, :, :d], pairs.b[:k]
    flat = nodes.reshape(len(nodes), -1)
    largest = flat[np.arange(len(flat)), np.abs(flat).argmax(axis=1)][:, None]
    borders = borders / largest
    return Modes(
        pairs.values[:k] * system.bending,
        in_space(nodes / largest[:, :, None]),
        borders[:, [S_A, S_B]],
        in_space(borders[:, X_C : X_C + d]),
        tuple(flip[:k]),
        tuple(plane[:k]),
        turns_freely(state),
        stability.sliding_stiffness(system) * system.bending,
    )
