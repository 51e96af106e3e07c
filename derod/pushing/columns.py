"""The columns of a run's table, each described once: type, unit, symbol, and where its value comes from.

Data types (``pushing.rows``), units in files, labels in plots and what extrapolation may improve are read off
this list.
``power`` is the power of ``rod.bending`` that turns a value of the rod's units into one of K0's.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

from derod.pushing.controls import CONTROLS, Control

if TYPE_CHECKING:
    import numpy as np

    from derod.equilibrium.measured import Measured


class Settled(NamedTuple):
    """How a state was settled: what a row says beside the state itself."""

    increment: int
    segment: int
    smooth: bool
    landing: bool
    residual: float  # K/D^2
    work_defect: float  # K/D
    iterations: int
    next_step: float  # of the control, as in files
    wall_time: float


@dataclass(frozen=True, slots=True)
class Column:
    """One field of a row."""

    name: str
    value: Callable[[Measured, Settled], Any]
    unit: str = ""
    """"" for counts and flags."""
    kind: str = "f8"
    power: int = 0
    symbol: str = ""
    """For labels, in LaTeX; the name where empty."""
    extrapolates: bool = False
    """Whether it has the rod's order in the mesh, so that two runs give a better value."""


def told(name: str, unit: str = "", kind: str = "f8", power: int = 0) -> Column:
    """Return the column of what ``Settled`` says."""
    return Column(name, lambda here, settled: getattr(settled, name), unit, kind, power)


def control_column(control: Control) -> Column:
    """Return the column of a control: the value each row was settled at."""
    return Column(
        control.name,
        lambda here, settled: control.value(here.state),
        control.unit,
        power=control.power,
        symbol=control.symbol,
    )


def energy_column(part: str) -> Column:
    """Return the column of a part of the energy."""
    return Column(
        f"energy_{part}",
        lambda here, settled: here.energies.parts[part],
        "K0 D-1",
        power=1,
        symbol=rf"E_{{{part}}}",
        extrapolates=True,
    )


def vector_columns(name: str, unit: str, read: Callable[[Measured], np.ndarray]) -> list[Column]:
    """Return the columns of the three components of a clamp's force or moment."""

    def component(k: int) -> Callable[[Measured, Settled], Any]:
        return lambda here, settled: read(here)[k]

    letter, place = ("n" if "force" in name else "m"), ("0" if "start" in name else "l")
    return [
        Column(f"{name}_{axis}", component(k), unit, power=1, symbol=f"{letter}_{axis}({place})")
        for k, axis in enumerate("xyz")
    ]


def end_tension(here: Measured, settled: Settled) -> float:
    """Return t; under a dead load exactly that."""
    physics = here.state.physics
    return float(physics.end_tension) if physics.slides else here.tension


FORCE, ENERGY = "K0 D-2", "K0 D-1"
COLUMNS: list[Column] = [
    told("increment", kind="i8"),
    control_column(CONTROLS["end_shortening"]),
    control_column(CONTROLS["end_rotation"]),
    Column("end_tension", end_tension, FORCE, power=1, symbol="t", extrapolates=True),
    Column("energy_hat", lambda here, _: here.energy_hat, ENERGY, power=1,
           symbol=r"\hat E", extrapolates=True),
    Column("energy_total", lambda here, _: here.energies.total, ENERGY, power=1,
           symbol="E_{tot}", extrapolates=True),
    energy_column("bend"),
    energy_column("twist"),
    energy_column("wall"),
    energy_column("capillary"),
    Column("wetted_length", lambda here, _: here.state.menisci[1] - here.state.menisci[0], "D",
           symbol="s_B - s_A", extrapolates=True),
    Column("meniscus_a", lambda here, _: here.state.menisci[0], "D", symbol="s_A"),
    Column("meniscus_b", lambda here, _: here.state.menisci[1], "D", symbol="s_B"),
    Column("force_a", lambda here, _: here.state.forces[0], FORCE, power=1,
           symbol="f_A", extrapolates=True),
    Column("force_b", lambda here, _: here.state.forces[1], FORCE, power=1,
           symbol="f_B", extrapolates=True),
    Column("holonomy", lambda here, _: here.state.holonomy, "rad", symbol=r"\psi"),
    Column("slide_force", lambda here, _: here.state.slide_force, FORCE, power=1, symbol=r"\eta"),
    Column("wall_gap", lambda here, _: here.wall_gap, "D", symbol=r"1 + \rho - 2 r"),
    Column("unstable_modes", lambda here, _: here.unstable_modes, kind="i4"),
    Column("slides", lambda here, _: here.slides, kind="?"),
    Column("converged", lambda here, _: here.settled, kind="?"),
    told("residual", FORCE, power=1),
    told("iterations", kind="i4"),
    told("work_defect", ENERGY, power=1),
    Column("turning_angle", lambda here, _: here.turning, "rad"),
    told("segment", kind="i4"),
    told("smooth", kind="?"),
    told("landing", kind="?"),
    told("next_step"),
    told("wall_time", "s"),
    *(control_column(CONTROLS[name]) for name in ("capillary_force", "wall_strength", "weight")),
    energy_column("weight"),
    Column("drop_height", lambda here, _: here.state.drop_center[1], "D",
           symbol="y_C", extrapolates=True),
    Column("twisting_moment", lambda here, _: here.reactions.twisting_moment, ENERGY, power=1,
           symbol="m_3", extrapolates=True),
    *vector_columns("start_force", FORCE, lambda here: here.reactions.start_force),
    *vector_columns("end_force", FORCE, lambda here: here.reactions.end_force),
    *vector_columns("start_moment", ENERGY, lambda here: here.reactions.start_moment),
    *vector_columns("end_moment", ENERGY, lambda here: here.reactions.end_moment),
]  # fmt: skip
"""In the order of the table; the first thirty are those of version 0.1 and what it soon grew."""
