"""Numbers, and angles and lengths written as "2.8 pi", read without surprises."""

from __future__ import annotations

import math
import re

NUMBER = r"(?:[0-9]+(?:\.[0-9]*)?|\.[0-9]+)(?:[eE][+-]?[0-9]+)?"
QUANTITY = re.compile(
    rf"\s*(?P<sign>[+-]?)\s*(?P<number>{NUMBER})?\s*(?P<pi>\*?\s*(?:pi|π))?"
    rf"\s*(?:/\s*(?P<divisor>{NUMBER}))?\s*",
    re.ASCII,
)
LONGEST_TEXT = 100
PI_DIGITS = 6


def read_number(value: object) -> float:
    """``value`` as a finite float; raises ValueError for all else, booleans and strings too."""
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise ValueError("is not a number")
    try:
        number = float(value)
    except OverflowError:
        raise ValueError("is too large") from None
    if not math.isfinite(number):
        raise ValueError("is not a finite number")
    return number


def read_integer(value: object) -> int:
    """``value`` if it is an integer and no boolean; raises ValueError otherwise."""
    if isinstance(value, bool) or not isinstance(value, int):
        raise ValueError("is not an integer")
    return value


def read_quantity(value: object) -> float:
    """An angle or a length: a number, or a string such as "2.8 pi", "-pi/2" or "1e-3".

    Raises ValueError, with the reason, for anything else.
    """
    if not isinstance(value, str):
        return read_number(value)
    match = QUANTITY.fullmatch(value) if len(value) <= LONGEST_TEXT else None
    if match is None or (match["number"] is None and match["pi"] is None):
        raise ValueError("is not understood as a number")
    if match["number"] is None and match["pi"].startswith("*"):
        raise ValueError("is not understood as a number")
    number = 1.0 if match["number"] is None else float(match["number"])
    if match["pi"] is not None:
        number *= math.pi
    if match["divisor"] is not None:
        divisor = float(match["divisor"])
        if divisor == 0.0:
            raise ValueError("divides by zero")
        number /= divisor
    return read_number(-number if match["sign"] == "-" else number)


def write_quantity(value: float) -> str:
    """The TOML text of an angle or a length, as a multiple of pi where that is short and exact.

    ``read_quantity`` gives back the very same float.
    """
    multiple = f"{value / math.pi:.{PI_DIGITS}g} pi"
    if value != 0.0 and read_quantity(multiple) == value:
        return '"pi"' if multiple == "1 pi" else f'"{multiple}"'
    return repr(value)
