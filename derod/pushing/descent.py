"""Go down from a state to a stable equilibrium, leaving every saddle on the way by a kick."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from derod.equilibrium.loop import Outcome, Solution
from derod.equilibrium.measured import Measured
from derod.equilibrium.system import System
from derod.pushing.kicks import Kick, kick
from derod.rod.state import State

MOST_KICKS = 12  # in one descent
FELL = 1e-9  # relative, the least that a kick must gain
LONGEST = 20_000  # iterations of one descent
STRONGER = 4.0  # each kick at one saddle than the one before
SAME_ENERGY = 1e-7  # relative, of two minima that are mirror images


@dataclass
class Descent:
    """Where a descent ended, and how it came there."""

    solution: Solution
    here: Measured | None  # None where it did not converge
    iterations: int
    kicks: list[Kick] = field(default_factory=list)
    other: float | None = (
        None  # energy of the minimum on a kick's other side, K/D, if it was looked at
    )

    @property
    def stable(self) -> bool:
        """Return whether a minimum was reached."""
        return self.here is not None and self.here.unstable_modes == 0

    def sides(self) -> str:
        """Say what decided which way the rod went."""
        count = len(self.kicks)
        text = f"{count} mode{'s' * (count > 1)} kicked, " if count else ""
        if self.other is not None and self.here is not None:
            higher = self.other - self.here.energy
            if abs(higher) > SAME_ENERGY * (1 + abs(self.other)):
                return f"{text}to the lower of two minima: the other's energy is higher by {higher:.3g}"
        if not count:
            return ""
        if all(k.mirror for k in self.kicks):
            return f"{text}the side is the seed's: mirror images of equal energy"
        equal = "" if self.other is None else ": both minima have equal energies"
        return f"{text}the side is the seed's{equal}"


@dataclass(frozen=True)
class Noise:
    """The seeded disturbance of one increment."""

    seed: int
    increment: int
    amplitude: float  # D; zero kicks nothing

    def start(self, attempt: int, shape: tuple[int, ...]) -> np.ndarray:
        """Return the vector that begins the search for a mode."""
        rng = np.random.default_rng([self.seed, self.increment, attempt])
        return rng.standard_normal(shape)


class Descender:
    """Goes down, by a relaxation, in one increment of a push."""

    def __init__(
        self,
        system: System,
        down: Callable[[State], Solution],
        analyse: Callable[[State], Measured],
        noise: Noise,
    ) -> None:
        self.system = system
        self.down = down
        self.analyse = analyse
        self.noise = noise

    def descend(self, start: State) -> Descent:
        """Go downhill from ``start`` to a minimum; without noise the descent may end at a saddle.

        Saddles are left by kicks, as soon as they are seen. Where a seed decides between two sides that are
        no mirror images, both are followed, and the lower minimum is taken.
        """
        solution = self.down(start)
        return self._onward(Descent(solution, None, solution.iterations), both=True)

    def probe(self, start: State, descent: Descent) -> Descent:
        """Go down once more from ``start``, disturbed by the noise; return the descent to the lower minimum.

        After a fold a rod may slide far, past ridges where little decides which way it goes on: where a
        disturbance leads to another minimum, the side is the seed's, and both energies are known.
        """
        if self.noise.amplitude == 0 or descent.here is None:
            return descent
        again = self.descend(disturbed(start, self.noise))
        if again.here is None or not again.stable:
            return descent
        best, other = sorted((descent, again), key=lambda one: one.here.energy if one.here else 0)
        if other.here is not None and best.other is None:
            best.other = other.here.energy
        best.iterations = descent.iterations + again.iterations
        return best

    def leave(self, settled: Solution, here: Measured) -> Descent:
        """Leave a settled, unstable state by a kick, and go down to a minimum."""
        return self._onward(Descent(settled, here, settled.iterations), both=True)

    def _onward(self, descent: Descent, *, both: bool) -> Descent:
        """Go on until a minimum is reached, or nothing helps."""
        system, noise = self.system, self.noise
        amplitude, energy = noise.amplitude, np.inf
        while True:
            solution = descent.solution
            if solution.converged:
                if descent.here is None:
                    descent.here = self.analyse(solution.state)
                if descent.here.unstable_modes == 0 or noise.amplitude == 0:
                    return descent
            elif solution.outcome is not Outcome.SADDLE:
                return descent
            if len(descent.kicks) >= MOST_KICKS or descent.iterations > LONGEST:
                return descent
            system.gradient(solution.state)
            before, energy = energy, system.energies(solution.state).potential
            fell_back = energy > before - FELL * (1 + abs(energy))
            amplitude = amplitude * STRONGER if fell_back else noise.amplitude
            vector = noise.start(len(descent.kicks), solution.state.q.shape)
            first = kick(system, solution.state, amplitude, vector)
            if first.sloped:  # the descent is on its way along the mode, and was moved on
                descent = continued(descent, self.down(first.state))
                continue
            descent.kicks.append(first)
            if both and not first.mirror:
                second = kick(system, solution.state, amplitude, vector, side=-1.0)
                return self._lower(descent, first, second)
            descent = continued(descent, self.down(first.state))

    def _lower(self, descent: Descent, first: Kick, second: Kick) -> Descent:
        """Go down on both sides of a saddle; return the descent to the lower minimum."""
        ends = []
        for side in (first, second):
            begun = Descent(descent.solution, None, 0, [*descent.kicks[:-1], side])
            ends.append(self._onward(continued(begun, self.down(side.state)), both=False))
        ends.sort(key=lambda end: end.here.energy if end.here and end.stable else np.inf)
        best, other = ends
        best.other = other.here.energy if other.here else None
        best.iterations = descent.iterations + sum(end.iterations for end in ends)
        return best


def disturbed(state: State, noise: Noise) -> State:
    """Return the state moved by five smooth waves of random directions, by about the noise's (D)."""
    rng = np.random.default_rng([noise.seed, noise.increment, MOST_KICKS + 1])
    d, n = state.dimension, state.q.shape[0] - 1
    place = np.linspace(0.0, np.pi, n + 1)[1:-1]
    moved = state.copy()
    for wave in range(1, 6):
        direction = rng.standard_normal(d) / wave
        moved.q[1:-1, :d] += 0.5 * noise.amplitude * np.outer(np.sin(wave * place), direction)
    return moved


def continued(descent: Descent, solution: Solution) -> Descent:
    """Return the descent after one more relaxation."""
    total = descent.iterations + solution.iterations
    return Descent(solution, None, total, descent.kicks, descent.other)
