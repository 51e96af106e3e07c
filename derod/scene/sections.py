"""Stiffnesses and the capillary force of circular and rectangular sections, as analytic formulas.

Each takes the measured quantities by symbol, in SI (E, nu, d or w and h, gamma, theta), which may be
complex: ``units.propagate`` differentiates them. Sources: Landau and Lifshitz, Theory of Elasticity,
sections 16 and 17; Timoshenko and Goodier, Theory of Elasticity, section 109 (the rectangle).
"""

from __future__ import annotations

import cmath
import math
from collections.abc import Mapping

Inputs = Mapping[str, complex]

ODD_FIFTH_POWERS = 31.0 / 32.0 * 1.03692775514336993  # sum of 1/n^5 over odd n, (31/32) zeta(5)
TORSION_TERMS = 15  # n = 1, 3, ... below this: exp(-15 pi) is nothing, for w >= h


def is_circle(x: Inputs) -> bool:
    """Whether the section is circular."""
    return "d" in x


def area(x: Inputs) -> complex:
    """A, m^2: pi d^2/4, or w h."""
    return math.pi * x["d"] ** 2 / 4.0 if is_circle(x) else x["w"] * x["h"]


def perimeter(x: Inputs) -> complex:
    """P, m: pi d, or 2 (w + h)."""
    return math.pi * x["d"] if is_circle(x) else 2.0 * (x["w"] + x["h"])


def stiffness(x: Inputs) -> complex:
    """K1, N m^2, the smaller bending stiffness: E pi d^4/64, or E w h^3/12."""
    if is_circle(x):
        return x["E"] * math.pi * x["d"] ** 4 / 64.0
    return x["E"] * x["w"] * x["h"] ** 3 / 12.0


def hard_stiffness(x: Inputs) -> complex:
    """K2, N m^2, the larger bending stiffness: K1, or E h w^3/12."""
    return stiffness(x) if is_circle(x) else x["E"] * x["h"] * x["w"] ** 3 / 12.0


def bending_ratio(x: Inputs) -> complex:
    """K2/K1: 1, or (w/h)^2."""
    return 1.0 if is_circle(x) else (x["w"] / x["h"]) ** 2


def torsion_factor(x: Inputs) -> complex:
    """beta of a rectangle, J = beta w h^3.

    beta = (1/3) (1 - (192/pi^5) (h/w) sum over odd n of tanh(n pi w/(2 h))/n^5)

    With tanh(y) = 1 - 2/(1 + exp(2 y)) the slow part of the sum is known in closed form.
    """
    aspect = x["w"] / x["h"]
    rest: complex = 0.0
    for n in range(1, TORSION_TERMS, 2):
        decay = cmath.exp(-n * math.pi * aspect)
        rest += 2.0 * decay / (1.0 + decay) / n**5
    return (1.0 - 192.0 / math.pi**5 * (ODD_FIFTH_POWERS - rest) / aspect) / 3.0


def torsion_constant(x: Inputs) -> complex:
    """J, m^4: pi d^4/32, or beta w h^3."""
    if is_circle(x):
        return math.pi * x["d"] ** 4 / 32.0
    return torsion_factor(x) * x["w"] * x["h"] ** 3


def twisting_ratio(x: Inputs) -> complex:
    """k3 = K3/K1 with K3 = G J, G = E/(2 (1 + nu)): 1/(1 + nu), or 6 beta/(1 + nu)."""
    factor = 1.0 if is_circle(x) else 6.0 * torsion_factor(x)
    return factor / (1.0 + x["nu"])


def capillary_force(x: Inputs) -> complex:
    """F_gamma, N: P (gamma_sv - gamma_sl), which is P gamma cos(theta) by Young's law."""
    return perimeter(x) * x["gamma"] * cmath.cos(x["theta"])
