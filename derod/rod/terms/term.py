"""What a term of the energy must say of itself."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from derod.scene import Scene

Constant = Callable[["Scene"], float]


@dataclass(frozen=True)
class Term:
    """One term of the energy: the module of this name holds its three functions, all ``inlined``.

    ::

        energy(physics, kin, q, b, psi)                           the energy, K/D
        add_gradient(physics, kin, q, b, psi, tension, grad)      its derivatives, by what they derive
        add_hessian(physics, kin, q, b, psi, tension, hess)       its second derivatives

    Terms only add. ``Gradient`` and ``Hessian`` (``rod.arrays``) have a slot for everything a term may
    derive by: direction, edge, place, rest length, dual length, drop.
    """

    module: str
    part: str
    """What its energy is counted as: the column ``energy_<part>``; terms may share one."""
    constants: Mapping[str, Constant] = field(default_factory=dict)
    """Its fields of ``Physics``, made from the scene: forces and energies over ``rod.bending``."""
    needs: str = ""
    """"drop" or "space": what must be there for it."""
    breaks_turn: str = ""
    """The constant that, where it is not zero, makes the turn about the clamp axis cost energy."""

    @property
    def name(self) -> str:
        """The module's last name."""
        return self.module.rpartition(".")[2]
