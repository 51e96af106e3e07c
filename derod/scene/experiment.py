"""An experiment in numbers: its quantities in SI, and what the model leaves out of it.

Every formula is in docs/si.md, with its source. Uncertainties are carried to first order from those
of [material], all taken as independent (``units.propagate``).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import NamedTuple

from derod.scene import sections
from derod.scene.material import inputs, length_ratio, pull
from derod.scene.tables import Material, Scene
from derod.scene.units import Measured, propagate, root

Inputs = Mapping[str, complex]
Formula = Callable[[Inputs], complex]


class Group(NamedTuple):
    """A number of a scene: dimensionless, unless it has a unit."""

    symbol: str
    value: float
    meaning: str
    error: float = 0.0
    """Standard uncertainty, to first order, from those of [material]."""
    unit: str = ""


def group_errors(scene: Scene, material: Material) -> dict[str, float]:
    """The uncertainties of the dimensionless groups, by their symbols in ``derod check``."""
    given = inputs(material)
    formulas: dict[str, Formula] = {
        "f_gamma D^2/K": pull,
        "L_EC/D": lambda x: pull(x) ** -0.5,
        "v0/(rho f_gamma)": lambda x: _wall(scene) / pull(x),
        "t_coil": pull,
        "t_plateau": pull,
    }
    if material.length is not None:
        formulas["l"] = length_ratio
        formulas["delta_end/pi"] = lambda x: length_ratio(x) / math.pi
    if material.poisson_ratio is not None:
        formulas["k3/K"] = sections.twisting_ratio
    return {symbol: propagate(formula, given).error for symbol, formula in formulas.items()}


def si_quantities(scene: Scene, material: Material) -> list[Group]:
    """The stiffnesses, forces and lengths of the experiment, in SI."""
    given = inputs(material)
    reach = 1.0 + scene.require_drop().wall_softness
    k3, length = scene.rod.twisting, scene.rod.length

    def twisting(x: Inputs) -> complex:
        ratio = sections.twisting_ratio(x) if "nu" in x else k3
        return ratio * sections.stiffness(x)

    def plateau(x: Inputs) -> complex:
        return sections.capillary_force(x) - 2.0 * unit_force(x) / reach**2

    rows: list[tuple[str, str, Formula, str]] = [
        ("L", "m", lambda x: x["L"] if "L" in x else length * x["D"], "rod length"),
        ("D", "m", lambda x: x["D"], "drop diameter, the unit of length"),
        ("K0", "N m^2", sections.stiffness, "bending stiffness, the smaller one, the unit"),
    ]
    if material.width is not None:
        rows.append(("K2", "N m^2", sections.hard_stiffness, "the larger bending stiffness"))
    rows += [
        ("K3", "N m^2", twisting, "twisting stiffness G J"),
        ("J", "m^4", sections.torsion_constant, "torsion constant of the section"),
        ("F_gamma", "N", sections.capillary_force, "capillary force P gamma cos(theta)"),
        ("K0/D^2", "N", unit_force, "the unit of force"),
        ("K0/D", "J", unit_energy, "the unit of energy and of moments (N m)"),
        ("L_EC", "m", elastocapillary_length, "elastocapillary length sqrt(K0/F_gamma)"),
        ("T_plateau", "N", plateau,
         "t_plateau in newtons, F_gamma - 2 K0/((1 + rho) D)^2"),
    ]  # fmt: skip
    return [_row(given, *row) for row in rows]


def left_out(material: Material) -> list[Group]:
    """What the model does not know, as numbers that should be small (or 1, for K2/K0)."""
    given = inputs(material)
    rows: list[tuple[str, str, Formula, str]]
    if material.width is None:
        rows = [
            ("d/D", "", lambda x: x["d"] / x["D"], "section over drop; a coil's largest strain")
        ]
    else:
        rows = [
            ("w/D", "", lambda x: x["w"] / x["D"], "width over drop"),
            ("h/D", "", lambda x: x["h"] / x["D"], "height over drop; a coil's largest strain"),
            ("w/h", "", lambda x: x["w"] / x["h"], "aspect ratio of the section"),
            ("K2/K0", "", lambda x: sections.hard_stiffness(x) / sections.stiffness(x),
             "ratio of the bending stiffnesses, (w/h)^2"),
            ("J/(w h^3)", "", sections.torsion_factor, "torsion constant of the rectangle"),
        ]  # fmt: skip
    rows += [("F_gamma/(gamma D)", "", lambda x: sections.capillary_force(x) / x["gamma"] / x["D"],
              "capillary force over the drop's own tension: how far it is pulled out of round")]  # fmt: skip
    if material.drop_density is not None:
        rows += [
            ("L_c", "m", lambda x: root(x["gamma"] / (x["rho_drop"] * x["g"])),
             "capillary length sqrt(gamma/(rho_drop g))"),
            ("Bo", "", lambda x: x["rho_drop"] * x["g"] * x["D"] ** 2 / (4.0 * x["gamma"]),
             "Bond number (D/(2 L_c))^2: gravity against the drop's surface tension"),
            ("M g", "N", weight, "weight of the drop"),
            ("W", "", lambda x: weight(x) / unit_force(x), "its weight over K0/D^2"),
            ("M g/F_gamma", "", lambda x: weight(x) / sections.capillary_force(x),
             "its weight over the capillary force"),
        ]  # fmt: skip
    if material.rod_density is not None:
        rows += [
            ("w_rod", "", lambda x: x["rho_rod"] * x["g"] * sections.area(x) * x["D"]
             / unit_force(x), "weight of a length D of the rod over K0/D^2"),
        ]  # fmt: skip
    return [_row(given, *row) for row in rows]


def unit_force(x: Inputs) -> complex:
    """K0/D^2, N."""
    return sections.stiffness(x) / x["D"] ** 2


def unit_energy(x: Inputs) -> complex:
    """K0/D, J."""
    return sections.stiffness(x) / x["D"]


def elastocapillary_length(x: Inputs) -> complex:
    """L_EC = sqrt(K0/F_gamma), m."""
    return root(sections.stiffness(x) / sections.capillary_force(x))


def weight(x: Inputs) -> complex:
    """M g of the whole drop, N: rho_drop g pi D^3/6."""
    return x["rho_drop"] * x["g"] * math.pi * x["D"] ** 3 / 6.0


def _wall(scene: Scene) -> float:
    drop = scene.require_drop()
    return drop.wall_strength / drop.wall_softness


def _row(
    given: Mapping[str, Measured], symbol: str, unit: str, formula: Formula, meaning: str
) -> Group:
    measured = propagate(formula, given)
    return Group(symbol, measured.value, meaning, measured.error, unit)
