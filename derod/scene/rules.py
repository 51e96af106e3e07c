"""What each key of a scene may hold by itself."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from derod.scene.controls import HELD, LARGEST, STRONGEST, WEAKEST
from derod.scene.program import SHORTENING, TENSION
from derod.scene.quantities import read_integer, read_number, read_quantity

METHODS = ("implicit", "elliptic", "fire", "kinetic")


@dataclass(frozen=True, slots=True)
class Key:
    """How one value is read: ``read`` raises ValueError with a reason, ``holds`` judges."""

    read: Callable[[Any], Any]
    holds: Callable[[Any], bool]
    allowed: str
    many: str = "no"  # "no": one value; "or": one value or a list; "list": a list


def _bending(value: object) -> float | tuple[float, float]:
    if not isinstance(value, list):
        return read_number(value)
    if len(value) != 2:
        raise ValueError("is no pair of bending stiffnesses")
    return read_number(value[0]), read_number(value[1])


def _pair(value: object) -> tuple[float, float]:
    if not isinstance(value, list) or len(value) != 2:
        raise ValueError("is no pair of numbers")
    return read_quantity(value[0]), read_quantity(value[1])


def _both_finite(value: tuple[float, float]) -> bool:
    return all(abs(x) <= LARGEST for x in value)


def _stiff(value: float | tuple[float, float]) -> bool:
    both = value if isinstance(value, tuple) else (value,)
    return all(WEAKEST <= x <= STRONGEST for x in both)


def _method(value: object) -> str:
    if not isinstance(value, str) or value not in METHODS:
        raise ValueError("is no relaxation method")
    return value


def _control(value: object) -> str:
    if not isinstance(value, str) or value not in HELD:
        raise ValueError("is no control")
    return value


def _side(value: object) -> str:
    if value not in ("down", "up"):
        raise ValueError("is no way to bend")
    return str(value)


def _switch(value: object) -> bool:
    if not isinstance(value, bool):
        raise ValueError("is neither true nor false")
    return value


def _any(_: object) -> bool:
    return True


def _finite(value: float) -> bool:
    return abs(value) <= STRONGEST


_end_shortening = HELD[SHORTENING].allowed
_PATH = {
    "control": Key(_control, _any, ", ".join(HELD)),
    "stop": Key(
        read_quantity, _finite, _end_shortening + ", or a list of turning points", many="or"
    ),
    "at": Key(
        read_quantity,
        _finite,
        "a list of end-shortenings above 0, e.g. ['0.1 pi', 1.5]",
        many="list",
    ),
    "max_step": Key(
        read_quantity, lambda x: 0.0 < x <= LARGEST, "a step of the end-shortening above 0"
    ),
}


def _held(name: str) -> Key:
    return Key(read_quantity, HELD[name].holds, HELD[name].allowed)


KEYS: dict[str, dict[str, Key]] = {
    "rod": {
        "length": Key(
            read_quantity,
            lambda x: 0.0 < x <= LARGEST,
            "a length above 1, the diameter of the drop, and up to 1e6",
        ),
        "bending": Key(_bending, _stiff, "a number from 1e-12 to 1e9, or two, [K1, K2]"),
        "twisting": Key(read_number, lambda x: 0.0 <= x <= STRONGEST, "a number from 0 to 1e9"),
        "natural_curvature": Key(
            _pair, _both_finite, "two numbers, [k1, k2], about d_1 and d_2, in 1/D"
        ),
        "natural_twist": Key(read_quantity, lambda x: abs(x) <= LARGEST, "a number, in rad/D"),
    },
    "drop": {
        "capillary_force": Key(
            read_number, lambda x: WEAKEST <= x <= STRONGEST, "a number from 1e-12 to 1e9"
        ),
        "wall_strength": Key(
            read_number, lambda x: WEAKEST <= x <= STRONGEST, "a number from 1e-12 to 1e9"
        ),
        "wall_softness": Key(
            read_quantity, lambda x: WEAKEST <= x <= 1.0, "a number from 1e-12 to 1"
        ),
        "weight": Key(read_number, HELD["weight"].holds, HELD["weight"].allowed),
    },
    "clamps": {
        **{name: _held(name) for name in ("end_rotation", SHORTENING, TENSION)},
        "directors": Key(
            _pair, _both_finite, "two angles from e_x to d_1, [alpha_0, alpha_L], e.g. [0, 'pi/2']"
        ),
    },
    "push": {
        **_PATH,
        "start": Key(read_quantity, _finite, _end_shortening),
        "locate": Key(_switch, _any, "true or false"),
        "bend": Key(_side, _any, "'down' or 'up'"),
    },
    "steps": _PATH,
    "mesh": {
        "edges": Key(read_integer, lambda n: 12 <= n <= 100_000, "an integer from 12 to 100000"),
        "wetted_share": Key(read_number, lambda x: 0.3 <= x <= 0.8, "a share from 0.3 to 0.8"),
        "layer": Key(read_number, lambda x: 0.01 <= x <= 1e3, "a number from 0.01 to 1000"),
        "inner_grading": Key(read_number, lambda x: 0.0 <= x <= 3.0, "a number from 0 to 3"),
    },
    "relax": {
        "method": Key(_method, _any, "'implicit', 'fire' or 'kinetic'"),
        "tolerance": Key(
            read_number, lambda x: 1e-15 <= x <= 1e-2, "a residual force from 1e-15 to 1e-2"
        ),
    },
    "noise": {
        "seed": Key(read_integer, lambda n: 0 <= n < 2**63, "an integer from 0 to 2^63 - 1"),
        "amplitude": Key(read_quantity, lambda x: 0.0 <= x <= 1.0, "a length from 0 to 1"),
    },
    "model": {
        "dimension": Key(read_integer, lambda n: n in (2, 3), "2 or 3"),
        "drop": Key(_switch, _any, "true or false"),
    },
}
QUANTITIES = {
    (table, name)
    for table, keys in KEYS.items()
    for name, key in keys.items()
    if key.read is read_quantity
}
