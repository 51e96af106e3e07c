"""Measured quantities: SI numbers, and strings such as "5.6 um" or "5.6 +- 0.5 um".

Every unit is an exact multiple of its SI unit (BIPM, SI Brochure, 9th edition, tables 7 and 8), degrees
are pi/180 rad. A value is multiplied by its unit exactly and rounded once, so that "5.6 um" is 5.6e-6.
"""

from __future__ import annotations

import cmath
import math
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from fractions import Fraction

from derod.scene.quantities import LONGEST_TEXT, NUMBER, read_number

DEGREE = "deg"
DIMENSIONS: dict[str, dict[str, str]] = {
    "length": {"m": "1", "cm": "1e-2", "mm": "1e-3", "um": "1e-6", "nm": "1e-9"},
    "pressure": {"Pa": "1", "kPa": "1e3", "MPa": "1e6", "GPa": "1e9"},
    "tension": {"N/m": "1", "mN/m": "1e-3", "dyn/cm": "1e-3"},
    "angle": {"rad": "1", DEGREE: "1"},
    "density": {"kg/m^3": "1", "g/cm^3": "1e3"},
    "acceleration": {"m/s^2": "1"},
    "number": {},
}
"""The units of each dimension as multiples of the first, which is the SI unit."""

SPELLINGS = {"µ": "u", "μ": "u", "°": DEGREE, "³": "^3", "²": "^2"}
MEASURE = re.compile(
    rf"\s*(?P<value>[+-]?\s*{NUMBER})\s*(?:(?:\+/?-|±)\s*(?P<error>{NUMBER}))?\s*(?P<unit>.*?)\s*",
    re.ASCII,
)
LARGEST = 1e100  # of anything, in SI: products of a few stay finite
SHORTEST = 12  # digits tried before a number is written in full
STEP = 1e-150
"""Of the complex step, relative: small enough for its square to vanish beside 1."""


@dataclass(frozen=True, slots=True)
class Measured:
    """A value and its standard uncertainty, both in one SI unit."""

    value: float
    error: float = 0.0


def read_measured(value: object, dimension: str) -> Measured:
    """``value`` in the SI unit of ``dimension``; raises ValueError with a reason.

    A number is taken in the SI unit; a string names its unit, unless the quantity has none.
    """
    if not isinstance(value, str):
        return _bounded(Measured(read_number(value)))
    match = MEASURE.fullmatch(value) if len(value) <= LONGEST_TEXT else None
    if match is None:
        raise ValueError("is not understood as a quantity")
    name = match["unit"]
    for spelling, plain in SPELLINGS.items():
        name = name.replace(spelling, plain)
    unit = _multiple(name, dimension)
    angle = math.pi / 180.0 if name == DEGREE else 1.0
    number = _times(match["value"].replace(" ", ""), unit) * angle
    error = _times(match["error"] or "0", unit) * angle
    return _bounded(Measured(read_number(number), read_number(error)))


def plain_measured(measured: Measured, dimension: str) -> str | float:
    """A quantity in the unit that keeps it short; ``read_measured`` gives back the very same."""
    if measured.error == 0.0 and not DIMENSIONS[dimension]:
        return measured.value
    texts = []
    for name, multiple in (DIMENSIONS[dimension] or {"": "1"}).items():
        scale = math.pi / 180.0 if name == DEGREE else float(multiple)
        digits = [f"{x / scale:.{SHORTEST}g}" for x in (measured.value, measured.error)]
        shown = digits[0] if measured.error == 0.0 else " +- ".join(digits)
        texts.append(f"{shown} {name}".rstrip())
    exact = [text for text in texts if _says(text, dimension, measured)]
    if exact:
        return min(exact, key=len)
    if measured.error == 0.0:
        return measured.value
    return f"{measured.value!r} +- {measured.error!r} {si_unit(dimension)}".rstrip()


def si_unit(dimension: str) -> str:
    """The SI unit of ``dimension``, "" for a number."""
    return next(iter(DIMENSIONS[dimension]), "")


def propagate(
    formula: Callable[[Mapping[str, complex]], complex], inputs: Mapping[str, Measured]
) -> Measured:
    """The value of an analytic ``formula`` and its uncertainty to first order, inputs independent.

        u^2 = sum_i (df/dx_i)^2 u_i^2        (JCGM 100:2008, GUM, equation 10)

    The partial derivatives are those of the formula itself, exact to rounding, by the complex step
    df/dx = Im f(x + i h)/h (Squire and Trapp, SIAM Review 40, 1998).
    """
    at: dict[str, complex] = {name: complex(x.value) for name, x in inputs.items()}
    value = formula(at).real
    slopes = []
    for name, x in inputs.items():
        if x.error != 0.0:
            step = STEP * (abs(x.value) or 1.0)
            slopes.append(formula({**at, name: complex(x.value, step)}).imag / step * x.error)
    return Measured(value, math.hypot(*slopes))


def _says(text: str, dimension: str, measured: Measured) -> bool:
    try:
        return read_measured(text, dimension) == measured
    except ValueError:  # rounded past the largest
        return False


def _bounded(measured: Measured) -> Measured:
    if max(abs(measured.value), measured.error) > LARGEST:
        raise ValueError("is too large")
    return measured


def _multiple(name: str, dimension: str) -> Fraction:
    units = DIMENSIONS[dimension]
    if name in units:
        return Fraction(units[name])
    if not name:
        if not units:
            return Fraction(1)
        raise ValueError("has no unit")
    for other, names in DIMENSIONS.items():
        if name in names:
            raise ValueError(f"is {'an' if other[0] == 'a' else 'a'} {other}")
    raise ValueError("has an unknown unit" if units else "has a unit, although it is a mere number")


def _times(text: str, unit: Fraction) -> float:
    exponent = re.split("[eE]", text)[1:]
    if exponent and len(exponent[0].lstrip("+-0")) > 3:
        raise ValueError("is out of all bounds")
    try:
        return float(Fraction(text) * unit)
    except OverflowError:
        raise ValueError("is too large") from None


def root(x: complex) -> complex:
    """The square root, for formulas."""
    return cmath.sqrt(x)
