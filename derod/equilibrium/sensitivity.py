r"""How a settled state changes with a parameter: the implicit function theorem, one solve each.

R(z, p) = 0 holds along the settled states, so that with the bordered matrix K = dR/dz, factored once,

    K dz/dp = -dR/dp - dR/dz_N dz_N/dp

z_N, the end clamp's place, is given; it moves with the end-shortening and with the length. The tension is
R's row of z_N, t = dL/dz_N, and the energy's slope is the partial derivative of the Lagrangian alone,
for the state is stationary. The mesh's own choices (number of edges, grading, the layer's width) are held.
Turning about the clamp axis is neutral, and dz/dp has no part of it; the drop's slide stays pinned.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass

import numpy as np

from derod.equilibrium.control import Control
from derod.equilibrium.measured import Measured, measure
from derod.equilibrium.parameters import CONSTANTS, Partial, of_control
from derod.equilibrium.system import System
from derod.rod.state import State
from derod.rod.unknowns import MOMENT


@dataclass(frozen=True, slots=True)
class Sensitivity:
    """Derivatives by one parameter p along the settled states, in the rod's units."""

    tension: float  # dt/dp
    energy_hat: float  # dE_hat/dp
    end_shortening: float  # d delta/dp
    twisting_moment: float  # dm_3/dp
    q: np.ndarray  # (N+1, d+1) of places and edge tensions
    b: np.ndarray  # (d+5,) of s_A, s_B, x_C, f_A, f_B, eta
    arc_length: np.ndarray  # (N+1,) of the nodes
    force: tuple[np.ndarray, np.ndarray]  # what was solved for: rows of nodes 1 ... N, border


@dataclass(frozen=True, slots=True)
class Setting:
    """What all solves at one state share."""

    here: Measured
    column: np.ndarray  # (N, d+1) dR/dz_N
    border: np.ndarray
    own: float  # d2L/dz_N^2, but for the twist's rank-one part


def sensitivities(
    system: System,
    state: State,
    controls: Mapping[str, Control],
    wanted: Collection[str] | None = None,
) -> tuple[Measured, dict[str, Sensitivity]]:
    """Return the measured state and its derivatives by the parameters of its scene, by name.

    ``controls`` are those of ``derod.pushing.controls``; ``wanted`` names some of ``parameters_of``, all if
    None. Afterwards the system holds the state's Hessian and its factor.
    """
    names = [name for name in parameters_of(state) if wanted is None or name in wanted]
    system.gradient(state)
    partials = {name: CONSTANTS[name](system, state) for name in names if name in CONSTANTS}
    moving = controls["end_tension" if state.physics.slides else "end_shortening"]
    here = measure(system, state, moving)
    last = system.dimension - 1
    setting = Setting(
        here, *system.end_column(state), float(system.room.hess.edge[system.edges, last, last])
    )
    out = {}
    for name in names:
        partial = partials.get(name)
        if partial is None:
            partial = of_control(controls[name], system, here)
        out[name] = solved(system, setting, name, partial)
    return here, out


def parameters_of(state: State) -> tuple[str, ...]:
    """Return the names of what a state depends on: the scene's keys, but for the bending stiffness.

    That is the unit: what it does follows from the others (``derod.record.sensitivities``).
    """
    physics = state.physics
    names = ["end_tension" if physics.slides else "end_shortening", "length"]
    if state.dimension == 3:
        names += ["twisting", "end_rotation"]
    if physics.drop:
        names += ["capillary_force", "wall_strength", "wall_softness", "weight"]
    return tuple(names)


def solved(system: System, setting: Setting, name: str, partial: Partial) -> Sensitivity:
    """Return the derivatives by the parameter ``name``, with the factor at hand."""
    here, d = setting.here, system.dimension
    state, physics = here.state, here.state.physics
    right, right_border = partial.column, partial.border
    if partial.end:
        right = right - partial.end * setting.column
        right_border = right_border - partial.end * setting.border
    rows, border = system.solve(right, right_border)
    q = np.zeros_like(state.q)
    q[1:] = rows
    q[-1, d - 1] += partial.end
    tension = partial.tension + setting.own * partial.end
    tension += float(np.sum(setting.column * rows) + setting.border @ border)
    shortening = (name == "length") - float(q[-1, d - 1])
    energy = partial.potential + physics.capillary_force * shortening
    if name == "capillary_force":
        energy += state.end_shortening + 1
    if physics.slides:  # E_tot leaves the load's potential T delta out
        tension = float(name == "end_tension")
        energy -= physics.end_tension * shortening + tension * state.end_shortening
    return Sensitivity(
        tension=tension,
        energy_hat=energy,
        end_shortening=shortening,
        twisting_moment=-float(border[MOMENT + d]) if d == 3 and physics.twisting > 0 else 0.0,
        q=q,
        b=border[: state.b.size],
        arc_length=carried(system, border, by_length=name == "length"),
        force=(right, right_border),
    )


def carried(system: System, border: np.ndarray, *, by_length: bool) -> np.ndarray:
    """Return the change of the nodes' arc length, (N+1,), as the menisci move and the rod grows."""
    slope = system.room.kin.slope[:, 1:-1]
    rest = border[0] * slope[0] + border[1] * slope[1]
    kin = system.room.kin
    if by_length and kin.node_b > kin.node_a:
        rest[kin.node_b :] -= slope[1, kin.node_b :]
    elif by_length:
        rest = kin.rest[1:-1] / kin.rest[1:-1].sum()
    return np.concatenate([[0.0], np.cumsum(rest)])
