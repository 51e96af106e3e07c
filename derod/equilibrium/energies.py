"""The energy of a state, by its parts."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from derod.rod.terms import TERMS

LOAD = "load"  # the part that is the potential of a dead load
PARTS = tuple(dict.fromkeys(term.part for term in TERMS if term.part != LOAD))
"""Names of the parts of E_tot, each once."""


@dataclass(frozen=True, slots=True)
class Energies:
    """Parts of the potential, in units of the rod's bending stiffness over D."""

    parts: Mapping[str, float]

    @property
    def total(self) -> float:
        """Return E_tot."""
        return sum(energy for part, energy in self.parts.items() if part != LOAD)

    @property
    def potential(self) -> float:
        """Return E_tot and the potential of a dead load: what a relaxation lowers."""
        return sum(self.parts.values())


def by_part(values: Sequence[float]) -> Energies:
    """Return the energies of all terms, in the order of their list, summed by parts."""
    parts: dict[str, float] = {}
    for term, value in zip(TERMS, values, strict=True):
        parts[term.part] = parts.get(term.part, 0.0) + float(value)
    return Energies(parts)
