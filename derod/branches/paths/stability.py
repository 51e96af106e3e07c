"""How many modes of a branch state are unstable, and how stiffly the drop holds its place.

The second variation (``second_variation``) is counted by the signs of pivots. A flip-symmetric
state splits it into flip-even and flip-odd variations of half the rod. Two flip-odd variations need
care:

- *Turning* the coil about the clamp axis (phi = e_z - d_3) costs nothing where the drop has no weight and
  the rod one bending stiffness. It is penalised then and never counted. With a weight it is a variation
  like others, and is counted: turned by a the rod keeps its energy, and W y_C becomes W y_C cos a, so that
  by itself it costs -W y_C a^2/2. With two stiffnesses it is counted too: the coil turns in the clamps'
  directors.
- *Sliding* the drop along the rod (rho = e_z - d_3): both menisci move along the rod by the same
  length c, all else follows. k = d^2E/dc^2, with everything else relaxed, is what the clamps'
  boundary layers make of it: about 2 |m|^2 sqrt(t) for a long outer rod, m the bending moment at a
  clamp. It falls like exp(-2 sqrt(t) outer length), below what a mesh resolves (0.01 K0/D^3 here,
  0.07 on Pt, which runs through the wall's cone). Variations are therefore counted with both
  menisci held in their place along the rod (c = 0), and one mode is added where sliding is resolved
  and downhill:

      |m| at the clamp > CLAMP_MOMENT   and   k < 0.

  By Haynsworth's formula that is the count of the whole second variation, c free, wherever |m| is
  above the threshold; below it sliding counts as neutral. The discrete rod uses the same rule
  (``derod.equilibrium.stability``), on its own numbers.

  With a weight k is no longer exponentially small: a drop on a taut rod is a bead on a string, k is about
  -W y_C (2/(l - delta))^2 and more where the coil takes part, and moments at the clamps say nothing. The
  mesh's error of k is estimated instead, from the same form on elements cut in two, and sliding is
  counted where

      k < 0   and   |k| > its error.

  Counts of a heavy state are those on the halved elements: turning is soft where W y_C is small.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from derod.branches.half_rod.element import moment, tangent
from derod.branches.half_rod.front import negative_eigenvalues
from derod.branches.half_rod.mesh import halved
from derod.branches.half_rod.second_variation import condensed
from derod.branches.half_rod.state import HalfRod

CLAMP_MOMENT = 0.15
"""Bending moment at the clamp (K/D) above which sliding is resolved. There k is 0.1 K/D^3 or more,
whatever its sign."""
NEUTRAL = 1e-3
"""K/D^2; up to 0.01 nothing else changed at 103 special points, at 0.1 two other modes were lost."""
CLAMP_ROWS = 3
"""Multipliers of rho(clamp) = 0: each brings one negative eigenvalue."""
PHI, RHO, CENTRE, TURN, SLIDE, LEFT = 0, 3, 6, 12, 13, 14
"""Places in what the sweep leaves at the middle, and its size."""


@dataclass(frozen=True, slots=True)
class Stability:
    """Unstable modes of the whole rod at fixed clamps."""

    even: int  # flip-even
    odd: int  # flip-odd, the drop held in its place along the rod
    sliding_stiffness: float  # k = d^2E/dc^2, all else relaxed, K/D^3
    clamp_moment: float  # |m - (m.d_3) d_3| at the clamp, K/D
    sliding_error: float | None = None  # mesh error of k, K/D^3, where the drop has a weight

    @property
    def slides(self) -> bool:
        """Whether sliding the drop is an unstable mode (flip-odd) beside the others."""
        if self.sliding_error is None:
            return self.clamp_moment > CLAMP_MOMENT and self.sliding_stiffness < 0.0
        return self.sliding_stiffness < -self.sliding_error

    @property
    def modes(self) -> int:
        """All of them."""
        return self.even + self.odd + self.slides


def stability(state: HalfRod, *, critical: bool = False) -> Stability:
    """Count the unstable modes of a settled state on its own mesh, of a heavy one on half of it.

    ``critical``: the state is a fold or a pitchfork. A flip-even mode is neutral there and is not
    counted: the form is raised by NEUTRAL |phi|^2, more than the mesh's error. Raises
    ArithmeticError where the elimination fails.
    """
    if state.weight == 0.0:
        return _counted(state, critical)
    coarse, fine = _counted(state, critical), _counted(halved(state), critical)
    error = abs(coarse.sliding_stiffness - fine.sliding_stiffness)
    return replace(fine, sliding_error=error)


def _counted(state: HalfRod, critical: bool) -> Stability:
    """The counts on the state's own mesh."""
    even, odd, block = _parts(state, NEUTRAL if critical else 0.0)
    # half a rod's form is x.F x = k c^2/2; the corner of the bordered inverse is -k/2
    stiffness = -2.0 * float(np.linalg.inv(block)[-1, -1])
    return Stability(even, odd, stiffness, clamp_moment(state))


def counts(
    state: HalfRod, raised: float | np.ndarray, core: float | None = None
) -> tuple[int, int]:
    """Numbers of unstable flip-even and flip-odd modes, the drop held in its place along the rod.

    ``raised`` and ``core`` as in ``condensed``: rotations about axes that are raised much take no part.
    """
    even, odd, _ = _parts(state, raised, core)
    return even, odd


def _parts(
    state: HalfRod, raised: float | np.ndarray, core: float | None = None
) -> tuple[int, int, np.ndarray]:
    """Even and odd counts, and the odd block that is left at the middle."""
    negative, left = condensed(state, raised, core)
    even = negative + negative_eigenvalues(_of_class(left, odd=False)) - CLAMP_ROWS
    neutral = state.weight == 0.0 and not state.parameters.anisotropic
    block = _of_class(left, odd=True, turn=neutral)
    odd = negative + negative_eigenvalues(block) - CLAMP_ROWS - 1 - neutral  # slide, and turn
    return even, odd, block


def clamp_moment(state: HalfRod) -> float:
    """Bending moment at the clamp, |m - (m.d_3) d_3|, K/D."""
    y = state.nodes[-1]
    t, m = np.empty(3), np.empty(3)
    tangent(y[3:7], t)
    moment(state.scalars[0], state.scalars[1], y[:3], y[7:10], m)
    return float(np.linalg.norm(m - (m @ t) * t))


def _of_class(left: np.ndarray, *, odd: bool, turn: bool = True) -> np.ndarray:
    """The rows and columns of flip-odd or flip-even variations; with ``turn`` that one is penalised."""
    keep = np.ones(LEFT, dtype=bool)
    for axis in (1,) if odd else (0, 2):
        keep[[PHI + axis, RHO + axis, CENTRE + axis]] = False
    keep[TURN] = odd and turn
    keep[SLIDE] = odd
    return left[np.ix_(keep, keep)]


def unstable_modes(state: HalfRod, *, critical: bool = False) -> tuple[int, int]:
    """Numbers of unstable flip-even and flip-odd modes, sliding among the latter."""
    found = stability(state, critical=critical)
    return found.even, found.odd + found.slides
