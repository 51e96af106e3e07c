r"""The square of the turning angle, as a smooth function of u = 1 - cos(phi).

Bending is measured by phi^2 over the dual length. In u it is analytic through phi = 0:
phi^2 = 2 sum_n (2u)^n / (n^2 binom(2n, n)), so no square root of a small number is taken.
"""

from __future__ import annotations

import math

from derod.algebra.jit import inlined, kernel

SERIES = tuple(2.0 ** (n + 1) / (n * n * math.comb(2 * n, n)) for n in range(10, 0, -1))
SERIES_LIMIT = 0.06  # phi = 0.35 rad; the ten terms leave 1e-16
OVER_SINE_SERIES = tuple(  # phi/sin(phi) = sum_n n!/(2n+1)!! u^n, from the last term
    2.0**n * math.factorial(n) ** 2 / math.factorial(2 * n + 1) for n in range(15, -1, -1)
)
OVER_SINE_LIMIT = 0.15  # phi = 0.55 rad; the terms leave 1e-18 of 1


@inlined
def small_squared_angle(u: float) -> tuple[float, float]:
    """Return phi^2 and its derivative by u, for u < SERIES_LIMIT."""
    value, first = 0.0, 0.0
    for c in SERIES:  # Horner's rule, and its derivative
        first = first * u + value
        value = value * u + c
    return value * u, first * u + value


@kernel
def squared_angle(u: float) -> tuple[float, float, float]:
    """Return phi^2 and its first two derivatives by u."""
    if u < SERIES_LIMIT:
        value, first, half_second = 0.0, 0.0, 0.0
        for c in SERIES:  # Horner's rule, and its derivatives
            half_second = half_second * u + first
            first = first * u + value
            value = value * u + c
        return value * u, first * u + value, 2 * (half_second * u + first)
    phi = 2 * math.asin(min(1.0, math.sqrt(0.5 * u)))
    sine = math.sqrt(max(u * (2 - u), 0.0))
    first = 2 * phi / sine
    return phi * phi, first, (2 - first * (1 - u)) / (sine * sine)


@kernel
def over_sine(u: float) -> tuple[float, float, float]:
    """Return phi/sin(phi) and its first two derivatives by u = 1 - cos(phi)."""
    if u < OVER_SINE_LIMIT:
        value, first, half_second = 0.0, 0.0, 0.0
        for c in OVER_SINE_SERIES:
            half_second = half_second * u + first
            first = first * u + value
            value = value * u + c
        return value, first, 2 * half_second
    phi = 2 * math.asin(min(1.0, math.sqrt(0.5 * u)))
    square = max(u * (2 - u), 0.0)  # of the sine
    value = phi / math.sqrt(square)
    first = (1 - (1 - u) * value) / square
    return value, first, (value - 3 * (1 - u) * first) / square
