"""How a recorded increment changes with every parameter of its scene, in the units of files.

The derivatives are those of ``derod.equilibrium.sensitivity``: one solve each, exact for the discrete rod on
its mesh. Forces count in the bending stiffness K there, so that a quantity Q = K^a f(p/K, ...) has

    dQ/dK = a Q/K - sum over the forces and stiffnesses p of (p/K) dQ/dp

and the bending stiffness needs no solve. At a fold the derivatives do not exist: dz/dp grows like
1/lambda along the mode whose eigenvalue lambda vanishes. Where the softest mode (``record.modes``) is softer
than SOFT of the clamped rod's own and carries most of dz/dp, they are said to be unbounded.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from derod.equilibrium import eigen
from derod.equilibrium.measured import Measured
from derod.equilibrium.sensitivity import Sensitivity, parameters_of, sensitivities
from derod.equilibrium.system import System
from derod.equilibrium.turning import turning, turns_freely
from derod.errors import DerodError
from derod.pushing.controls import CONTROLS
from derod.record.modes import state_of
from derod.rod.state import State, in_space
from derod.rod.unknowns import F_A, S_A, X_C

if TYPE_CHECKING:
    from derod.record.run import BaseRun

SCALED = ("end_tension", "twisting", "capillary_force", "wall_strength", "weight")
"""Parameters that count in K."""
CLAMPED_ROD = 4.730041**4  # l^4/K times the lowest eigenvalue of a straight rod between clamps
SOFT = 0.01  # of that, below which a mode is near a fold's
MOST = 0.5  # of the norm of dz/dp, in the soft mode
TURNS = 1e-6  # relative, of a force that turns the coil
QUANTITIES = {
    "end_tension": 1, "energy_hat": 1, "end_shortening": 0, "twisting_moment": 1, "menisci": 0,
    "forces": 1, "drop": 0, "positions": 0, "arc_length": 0, "edge_tension": 1,
}  # fmt: skip
"""What is derived, and its power of K."""


class SensitivityError(DerodError, ValueError):
    """Derivatives that do not exist here."""


@dataclass(frozen=True, repr=False)
class Sensitivities:
    """Derivatives at an increment, a row each of ``parameters`` (P of them).

    In the units of runs: lengths D, forces K0/D^2, energies K0/D, stiffnesses K0, angles rad.
    """

    parameters: tuple[str, ...]
    """The scene's keys."""
    values: np.ndarray
    """What they are, (P,)."""
    end_tension: np.ndarray
    """dt/dp, (P,)."""
    energy_hat: np.ndarray
    """dE_hat/dp, (P,)."""
    end_shortening: np.ndarray
    """(P,); other than 0 and 1 under a dead load only."""
    twisting_moment: np.ndarray
    """(P,)."""
    menisci: np.ndarray
    """Of s_A and s_B, (P, 2)."""
    forces: np.ndarray
    """Of f_A and f_B, (P, 2)."""
    drop: np.ndarray
    """Of the drop's centre, (P, 3)."""
    positions: np.ndarray
    """Of the nodes, (P, N+1, 3)."""
    arc_length: np.ndarray
    """Of the nodes, (P, N+1): they move along the rod with the menisci."""
    edge_tension: np.ndarray
    """(P, N)."""
    eigenvalue: float
    """Of the mode nearest to neutral, K0/D^4; NaN where it was not asked for."""
    unbounded: np.ndarray
    """Whether the derivatives grow without bound here, near a fold, (P,)."""

    def __getitem__(self, parameter: str) -> dict[str, np.ndarray]:
        """The derivatives by one parameter, by the quantity's name; raises KeyError."""
        if parameter not in self.parameters:
            raise KeyError(f"{parameter!r}; allowed: {', '.join(self.parameters)}")
        row = self.parameters.index(parameter)
        return {name: getattr(self, name)[row] for name in QUANTITIES}

    def __repr__(self) -> str:
        parts = [
            f"{name} unbounded" if wild else f"{name} {slope:.6g}"
            for name, slope, wild in zip(
                self.parameters, self.end_tension, self.unbounded, strict=True
            )
        ]
        return f"<sensitivities, dt/dp: {', '.join(parts)}>"


def sensitivities_of(run: BaseRun, i: int) -> Sensitivities:
    """See ``BaseRun.sensitivities``."""
    return sensitivities_at(*state_of(run, i))


def sensitivities_at(
    system: System, state: State, wanted: Sequence[str] | None = None, *, bounds: bool = True
) -> Sensitivities:
    """Return the derivatives at a settled state (rod's units) by all parameters, or those ``wanted``.

    ``bounds`` tells whether to look for a soft mode, which takes about as long as all solves together.
    Raises ``SensitivityError`` for a parameter that the scene lacks, and for sections with directions.
    """
    if system.scene.has_frames:
        raise SensitivityError(
            "the section has directions (rod.bending = [K1, K2] or a natural shape): allowed: round sections"
        )
    known = (*parameters_of(state), "bending")
    names = known if wanted is None else tuple(wanted)
    for name in names:
        if name not in known:
            raise SensitivityError(f"parameter = {name!r}: allowed: {', '.join(known)}")
    solved = names if "bending" not in names else (*names, *SCALED)
    here, found = sensitivities(system, state, CONTROLS, solved)
    by_name = {name: scaled(here, one, name, system.bending) for name, one in found.items()}
    values = {name: value_of(state, name, system.bending) for name in found}
    if "bending" in names:
        own = quantities_of(here, system.bending)
        by_name["bending"] = {
            quantity: power * own[quantity] / system.bending
            - sum(
                values[name] / system.bending * by_name[name][quantity]
                for name in SCALED
                if name in by_name
            )
            for quantity, power in QUANTITIES.items()
        }
        values["bending"] = system.bending
    eigenvalue, wild = np.nan, dict.fromkeys(names, False)
    if bounds:
        eigenvalue, wild = soft_mode(system, here, found)
        wild["bending"] = any(wild[name] for name in SCALED if name in wild and values[name] != 0)
    columns = {key: np.array([by_name[name][key] for name in names]) for key in QUANTITIES}
    return Sensitivities(
        parameters=names,
        values=np.array([values[name] for name in names]),
        eigenvalue=eigenvalue * system.bending,
        unbounded=np.array([wild[name] for name in names]),
        **columns,
    )


def value_of(state: State, name: str, unit: float) -> float:
    """Return a parameter's value as in files."""
    value = state.end_shortening if name == "end_shortening" else getattr(state.physics, name)
    return float(value) * (unit if name in SCALED else 1.0)


def scaled(here: Measured, one: Sensitivity, name: str, unit: float) -> dict[str, np.ndarray]:
    """Return the derivatives by a parameter in the units of files."""
    d = here.state.dimension
    raw = {
        "end_tension": one.tension,
        "energy_hat": one.energy_hat,
        "end_shortening": one.end_shortening,
        "twisting_moment": one.twisting_moment,
        "menisci": one.b[S_A : S_A + 2],
        "forces": one.b[F_A + d : F_A + d + 2],
        "drop": in_space(one.b[X_C : X_C + d]),
        "positions": in_space(one.q[:, :d]),
        "arc_length": one.arc_length,
        "edge_tension": one.q[1:, d],
    }
    power = int(name in SCALED)
    return {key: np.asarray(raw[key]) * unit ** (QUANTITIES[key] - power) for key in QUANTITIES}


def quantities_of(here: Measured, unit: float) -> dict[str, np.ndarray]:
    """Return what is derived, in the units of files; zero where K does not enter."""
    state, d = here.state, here.state.dimension
    forces = {
        "end_tension": state.physics.end_tension if state.physics.slides else here.tension,
        "energy_hat": here.energy_hat,
        "twisting_moment": here.reactions.twisting_moment,
        "forces": state.b[F_A + d : F_A + d + 2],
        "edge_tension": state.edge_tension,
    }
    return {name: np.asarray(forces.get(name, 0.0)) * unit for name in QUANTITIES}


def soft_mode(
    system: System, here: Measured, found: Mapping[str, Sensitivity]
) -> tuple[float, dict[str, bool]]:
    """Return the eigenvalue nearest to zero (K/D^4), and which derivatives its mode makes unbounded."""
    state, d = here.state, system.dimension
    pairs = eigen.lowest(system, state, here.unstable_modes + 1)
    nearest = int(np.argmin(abs(pairs.values)))
    value = float(pairs.values[nearest])
    soft = abs(value) < SOFT * CLAMPED_ROD / state.physics.length**4
    metric = eigen.Metric(system, state)
    rows, border = turning(state, system.factor.rhs_border.size)
    turn = float(np.linalg.norm(metric.down(rows, border))) if turns_freely(state) else 0.0
    wild = {}
    for name, one in found.items():
        force, force_border = one.force
        pull = np.sum(force[:, :d] * pairs.q[nearest, 1:, :d])
        pull += force_border[: X_C + d] @ pairs.b[nearest, : X_C + d]
        size = float(np.linalg.norm(metric.down(one.q[1:], one.b)))
        twists = abs(np.sum(force * rows) + force_border @ border)
        wild[name] = bool(
            (soft and abs(pull / value) > MOST * size)
            or (name == "weight" and turn > 0 and twists > TURNS * turn)
        )
    return value, wild


def slopes(
    run: BaseRun,
    parameters: Sequence[str],
    quantity: str = "end_tension",
    increments: Sequence[int] | None = None,
) -> np.ndarray:
    """Return d(quantity)/dp at increments of a run (all if None), (T, P, ...): what a fit needs.

    ``quantity`` is one of QUANTITIES. One linearisation a row, one solve a parameter; bounds are not
    looked for.
    """
    if quantity not in QUANTITIES:
        raise SensitivityError(f"quantity = {quantity!r}: allowed: {', '.join(QUANTITIES)}")
    out, system = [], System(run.scene)
    for i in range(len(run)) if increments is None else increments:
        _, state = state_of(run, i, system)
        found = sensitivities_at(system, state, parameters, bounds=False)
        out.append(getattr(found, quantity))
    return np.array(out)
