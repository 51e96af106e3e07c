"""The table [material]: an experiment in SI, and the dimensionless scene that it makes.

The groups are the paper's (eq:adim), D and K0 = K1 being the units:

    l = L/D    k3 = K3/K1    f_gamma = F_gamma D^2/K1    F_gamma = P gamma cos(theta)

F_gamma = P (gamma_sv - gamma_sl) is the paper's; Young's law turns it into what is measured. The
stiffnesses are in ``derod.scene.sections``, every formula in docs/si.md.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from typing import Any, NoReturn

from derod.errors import SceneError
from derod.scene.rules import KEYS, Key
from derod.scene.sections import bending_ratio, capillary_force, stiffness, twisting_ratio
from derod.scene.tables import Material
from derod.scene.units import DIMENSIONS, Measured, plain_measured, propagate, read_measured

DIMENSION_OF = {
    "young_modulus": "pressure",
    "poisson_ratio": "number",
    "diameter": "length",
    "width": "length",
    "height": "length",
    "surface_tension": "tension",
    "contact_angle": "angle",
    "drop_diameter": "length",
    "length": "length",
    "drop_density": "density",
    "rod_density": "density",
    "gravity": "acceleration",
}
SYMBOLS = {
    "young_modulus": "E",
    "poisson_ratio": "nu",
    "diameter": "d",
    "width": "w",
    "height": "h",
    "surface_tension": "gamma",
    "contact_angle": "theta",
    "drop_diameter": "D",
    "length": "L",
    "drop_density": "rho_drop",
    "rod_density": "rho_rod",
    "gravity": "g",
}
"""Of the keys, as the formulas name them."""

RIGHT_ANGLE = 1.5707  # rad; at a right angle nothing pulls the rod in
PUSH_LENGTHS = ("start", "stop", "at", "max_step")


def _positive(name: str, least: float, most: float, example: str) -> Key:
    """Of a quantity above zero, whose uncertainty leaves it there."""
    units = ", ".join(DIMENSIONS[DIMENSION_OF[name]])
    return Key(
        partial(read_measured, dimension=DIMENSION_OF[name]),
        lambda x: least <= x.value <= most and x.error < x.value,
        f"a {DIMENSION_OF[name]} from {least:g} to {most:g} {units.split(',')[0]}, more than its "
        f"uncertainty, e.g. {example}; units: {units}",
    )


_length = partial(_positive, least=1e-9, most=1e3)
MATERIAL_KEYS: dict[str, Key] = {
    "young_modulus": _positive("young_modulus", 1e-3, 1e15, "'17 MPa'"),
    "poisson_ratio": Key(
        partial(read_measured, dimension="number"),
        lambda x: -1.0 < x.value <= 0.5,
        "a number above -1 and up to 0.5, e.g. 0.5 or '0.49 +- 0.01'",
    ),
    "diameter": _length("diameter", example="'5.6 +- 0.5 um'"),
    "width": _length("width", example="'160 um'"),
    "height": _length("height", example="'40 um'"),
    "surface_tension": _positive("surface_tension", 1e-9, 1e3, "'21.1 mN/m'"),
    "contact_angle": Key(
        partial(read_measured, dimension="angle"),
        lambda x: 0.0 <= x.value <= RIGHT_ANGLE,
        "an angle from 0 to below 90 deg, where the liquid wets the rod, e.g. '23 deg'; units: rad, deg",
    ),
    "drop_diameter": _length("drop_diameter", example="'200.2 um'"),
    "length": _length("length", example="'3.4 mm'"),
    "drop_density": _positive("drop_density", 1e-3, 1e5, "'960 kg/m^3'"),
    "rod_density": _positive("rod_density", 1e-3, 1e5, "'1200 kg/m^3'"),
    "gravity": Key(
        partial(read_measured, dimension="acceleration"),
        lambda x: 0.0 <= x.value <= 1e3,
        "an acceleration from 0 to 1000 m/s^2; units: m/s^2",
    ),
}


def inputs(material: Material) -> dict[str, Measured]:
    """The measured quantities that are given, by the symbols of the formulas, in SI."""
    values = ((symbol, getattr(material, name)) for name, symbol in SYMBOLS.items())
    return {symbol: value for symbol, value in values if value is not None}


def length_ratio(x: Mapping[str, complex]) -> complex:
    """l = L/D."""
    return x["L"] / x["D"]


def pull(x: Mapping[str, complex]) -> complex:
    """f_gamma = F_gamma D^2/K1."""
    return capillary_force(x) * x["D"] ** 2 / stiffness(x)


def derived(material: Material) -> dict[tuple[str, str], Measured]:
    """The keys of [rod] and [drop] that ``material`` gives, with their uncertainties."""
    given = inputs(material)
    values = {
        ("rod", "bending"): Measured(1.0),
        ("drop", "capillary_force"): propagate(pull, given),
    }
    if material.length is not None:
        values["rod", "length"] = propagate(length_ratio, given)
    if material.poisson_ratio is not None:
        values["rod", "twisting"] = propagate(twisting_ratio, given)
    return values


def plain_material(material: Material) -> dict[str, Any]:
    """The table as it is written in a file."""
    values = {name: getattr(material, name) for name in DIMENSION_OF}
    return {
        name: plain_measured(value, DIMENSION_OF[name])
        for name, value in values.items()
        if value is not None
    }


def with_groups(
    data: Mapping[str, Any], material: Material, path: str | None
) -> dict[str, dict[str, Any]]:
    """The tables ``data`` with what ``material`` gives filled in, all of it dimensionless.

    Lengths of [push] with a unit, such as "0.5 mm", are divided by D. Raises SceneError where
    something is missing, is given twice, or makes no scene.
    """
    _check_section(material, path)
    tables = {name: dict(table) for name, table in data.items() if name != "material"}
    rod, drop = tables.setdefault("rod", {}), tables.setdefault("drop", {})
    for name, value, other in (
        ("length", material.length, "length"),
        ("poisson_ratio", material.poisson_ratio, "twisting"),
    ):
        if value is None and other not in rod:
            _missing(name, f"{MATERIAL_KEYS[name].allowed} (or rod.{other} instead)", path)
    for (table, name), measured in derived(material).items():
        if name in tables[table]:
            key, allowed = f"{table}.{name}", "to leave it out, or the whole table [material]"
            if (table, name) in (("rod", "length"), ("rod", "twisting")):
                partner = "length" if name == "length" else "poisson_ratio"
                allowed = f"one of {key} and material.{partner}"
            raise SceneError(
                "is given, and [material] gives it too",
                file=path,
                key=key,
                value=tables[table][name],
                allowed=allowed,
            )
        _check_group(table, name, measured.value, material, path)
    for (table, name), measured in derived(material).items():
        (rod if table == "rod" else drop)[name] = measured.value
    ratio = propagate(bending_ratio, inputs(material)).value
    if ratio != 1.0:
        rod["bending"] = [rod["bending"], ratio]
    push = tables.get("push", {})
    for name in PUSH_LENGTHS:
        if name in push:
            push[name] = _in_diameters(push[name], material.drop_diameter.value)
    return tables


def _check_section(material: Material, path: str | None) -> None:
    """A diameter, or a width and a height that is no larger."""
    d, w, h = material.diameter, material.width, material.height
    sections = "a diameter (circular section), or a width and a height (rectangular section)"
    if d is not None and (w is not None or h is not None):
        extra, value = ("width", w) if w is not None else ("height", h)
        _wrong(extra, value, "is given beside a diameter", sections, path)
    if d is None and w is None and h is None:
        _missing("diameter", sections, path)
    if d is None and (w is None or h is None):
        name = "width" if w is None else "height"
        _missing(name, MATERIAL_KEYS[name].allowed, path)
    if w is not None and h is not None and w.value < h.value:
        allowed = f"at least the height, {plain_measured(h, 'length')}: the height is the thin side"
        _wrong("width", w, "is less than the height", allowed, path)


def _check_group(table: str, name: str, value: float, material: Material, path: str | None) -> None:
    """The group must be one that [rod] or [drop] could hold; blames the key of [material]."""
    fits = KEYS[table][name].holds(value)
    if name == "length" and not (fits and value > 1.0):
        allowed = "a length of more than the drop's diameter and up to 1e6 of them"
        _wrong("length", material.length, f"makes l = L/D = {value:.6g}", allowed, path)
    if not fits:
        group = "f_gamma" if name == "capillary_force" else "k3"
        blamed = "young_modulus" if group == "f_gamma" else "poisson_ratio"
        allowed = f"what makes {group} {KEYS[table][name].allowed}"
        _wrong(blamed, getattr(material, blamed), f"makes {group} = {value:.6g}", allowed, path)


def _in_diameters(value: Any, diameter: float) -> Any:
    """Lengths with a unit over D; all else as it is, for the rules of [push] to judge."""
    if isinstance(value, list):
        return [_in_diameters(item, diameter) for item in value]
    if not isinstance(value, str):
        return value
    try:
        measured = read_measured(value, "length")
    except ValueError:
        return value
    return value if measured.error else measured.value / diameter


def _missing(name: str, allowed: str, path: str | None) -> NoReturn:
    raise SceneError("is missing", file=path, key=f"material.{name}", allowed=allowed)


def _wrong(
    name: str, value: Measured | None, problem: str, allowed: str, path: str | None
) -> NoReturn:
    shown = None if value is None else plain_measured(value, DIMENSION_OF[name])
    raise SceneError(problem, file=path, key=f"material.{name}", value=shown, allowed=allowed)
