"""How the values of one key are spread: a list, a range, or a normal distribution.

Written as in TOML::

    [8, 10, 12]                                            a list
    {from = 10, to = 40, count = 7, spacing = "log"}       a range; ``count`` is for grids and lists
    {normal = [20, 0.5]}                                   mean and standard deviation, for samples
    "5.6 +- 0.5 um"                                        the same of a measured quantity of [material]
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, NoReturn

import numpy as np

from derod.errors import SceneError
from derod.scene.material import DIMENSION_OF
from derod.scene.plain import plain
from derod.scene.quantities import read_integer
from derod.scene.reading import ALL_KEYS
from derod.scene.rules import Key
from derod.scene.units import Measured, read_measured

MOST_VALUES = 1_000_000
Value = float | int | str | bool
FORMS = "a list of values, {from, to, count, spacing = 'linear' or 'log'}, or {normal = [mean, deviation]}"


@dataclass(frozen=True, slots=True)
class Spread:
    """The values of one key, as a grid or a list takes them, or as a sample maps [0, 1) to them."""

    key: str
    values: tuple[Value, ...] = ()
    """Of a list, or of a range with a count; empty where there is only a distribution."""
    low: float = math.nan
    high: float = math.nan
    log: bool = False
    mean: float = math.nan
    deviation: float = math.nan
    written: Any = None
    """As it is read back."""

    @property
    def is_distribution(self) -> bool:
        """Whether samples can be drawn from it."""
        return math.isfinite(self.low) or math.isfinite(self.mean)

    def draw(self, share: np.ndarray) -> np.ndarray:
        """Values at the shares (n,) in [0, 1) of the distribution."""
        if math.isfinite(self.mean):
            from scipy.special import ndtri

            inside = np.clip(share, 1e-12, 1.0 - 1e-12)
            return np.asarray(self.mean + self.deviation * ndtri(inside))
        return _between(self.low, self.high, share, self.log)


def read_spread(key: str, written: Any, file: str | None = None) -> Spread:
    """The spread of one key, each of its values checked as a scene would. Raises SceneError."""
    rule = rule_of(key, file)
    if isinstance(written, np.ndarray):
        written = written.tolist()
    if isinstance(written, str) and key.startswith("material.") and _has_error(key, written):
        return _measured(key, written, rule, file)
    if isinstance(written, Mapping):
        return _from_table(key, dict(written), rule, file)
    if not isinstance(written, list | tuple) or not written:
        _wrong(key, written, "is no spread of values", FORMS, file)
    values = tuple(_value(f"{key}[{i}]", x, rule, file) for i, x in enumerate(written))
    return Spread(key, values, written=[plain(x) for x in written])


def rule_of(key: str, file: str | None = None) -> Key:
    """The rule of a scene's key with a dot.

    Raises SceneError where there is none, or where it holds a list.
    """
    table, _, name = str(key).partition(".")
    rule = ALL_KEYS.get(table, {}).get(name)
    if rule is None or table == "steps":
        allowed = "a key of a scene with its table, such as drop.capillary_force or rod.length"
        raise SceneError("is no key of a scene that can vary", file=file, key=str(key),
                         allowed=allowed)  # fmt: skip
    if rule.many == "list":
        raise SceneError("holds a list, which cannot vary", file=file, key=key,
                         allowed="to give it once for all points, under [set]")  # fmt: skip
    return rule


def _from_table(key: str, table: dict[str, Any], rule: Key, file: str | None) -> Spread:
    known = {"from", "to", "count", "spacing"} if "normal" not in table else {"normal"}
    for name in table:
        if name not in known:
            _wrong(f"{key}.{name}", table[name], "is unknown", FORMS, file)
    if "normal" in table:
        pair = table["normal"]
        if not isinstance(pair, list | tuple) or len(pair) != 2:
            _wrong(f"{key}.normal", pair, "is no pair", "[mean, deviation]", file)
        mean = _number(f"{key}.normal[0]", pair[0], rule, file)
        deviation = _size(f"{key}.normal[1]", pair[1], key, file)
        return Spread(key, mean=mean, deviation=deviation,
                      written={"normal": [mean, deviation]})  # fmt: skip
    for name in ("from", "to"):
        if name not in table:
            _wrong(f"{key}.{name}", None, "is missing", FORMS, file)
    low, high = (_number(f"{key}.{name}", table[name], rule, file) for name in ("from", "to"))
    spacing, count = table.get("spacing", "linear"), table.get("count", 0)
    if spacing not in ("linear", "log"):
        _wrong(f"{key}.spacing", spacing, "is no spacing", "'linear' or 'log'", file)
    log = spacing == "log"
    if log and not (low > 0.0 and high > 0.0):
        _wrong(f"{key}.from", low, "has no logarithm", "values above 0", file)
    if isinstance(count, bool) or not isinstance(count, int) or not 0 <= count <= MOST_VALUES:
        _wrong(f"{key}.count", count, "is no number of values", "1, 2, 3, ...", file)
    if low == high and count != 1:
        _wrong(f"{key}.to", high, "is where the range begins", "another value", file)
    values: tuple[Value, ...] = ()
    if count:
        values = tuple(
            _value(f"{key}[{i}]", x, rule, file)
            for i, x in enumerate(_evenly(key, low, high, count, log))
        )
    written = {"from": low, "to": high, **({"count": count} if count else {}), "spacing": spacing}
    return Spread(key, values, low, high, log, written=written)


def _evenly(key: str, low: float, high: float, count: int, log: bool) -> list[float | int]:
    share = np.zeros(1) if count == 1 else np.arange(count) / (count - 1)
    return settled(key, _between(low, high, share, log))


def settled(key: str, values: np.ndarray) -> list[float | int]:
    """Numbers of a key as a scene takes them: whole ones where it counts."""
    table, _, name = key.partition(".")
    if ALL_KEYS[table][name].read is read_integer:
        return [int(x) for x in np.rint(values)]
    return [float(x) for x in values]


def _between(low: float, high: float, share: np.ndarray, log: bool) -> np.ndarray:
    if log:
        return np.asarray(np.where(share == 1.0, high, low * (high / low) ** share))
    return np.asarray(low + (high - low) * share)


def _measured(key: str, written: str, rule: Key, file: str | None) -> Spread:
    measured = rule.read(written)
    _value(key, written, rule, file)
    return Spread(key, mean=measured.value, deviation=measured.error,
                  written={"normal": [measured.value, measured.error]})  # fmt: skip


def _has_error(key: str, written: str) -> bool:
    try:
        found = read_measured(written, DIMENSION_OF[key.partition(".")[2]])
    except (KeyError, ValueError):
        return False
    return found.error > 0.0


def _value(key: str, given: Any, rule: Key, file: str | None) -> Value:
    """One value as a point has it: a number of a quantity, a text or a switch."""
    given = plain(given)
    try:
        read = rule.read(given)
        if not rule.holds(read):
            raise ValueError("is out of range")
    except ValueError as error:
        _wrong(key, given, str(error), rule.allowed, file, error)
    if isinstance(read, Measured):
        return read.value
    if not isinstance(read, float | int | str):
        _wrong(key, given, "is no single value", rule.allowed, file)
    return read


def _number(key: str, given: Any, rule: Key, file: str | None) -> float:
    value = _value(key, given, rule, file)
    if isinstance(value, bool | str):
        _wrong(key, given, "is not a number", "a number", file)
    return float(value)


def _size(key: str, given: Any, of: str, file: str | None) -> float:
    """A standard deviation, in the unit of the key ``of``."""
    name = of.partition(".")[2]
    try:
        if isinstance(given, str) and of.startswith("material."):
            size = read_measured(given, DIMENSION_OF[name]).value
        else:
            size = read_measured(given, "number").value
        if not size > 0.0:
            raise ValueError("is out of range")
    except ValueError as error:
        _wrong(key, given, str(error), "a standard deviation above 0", file, error)
    return size


def _wrong(
    key: str,
    value: Any,
    problem: str,
    allowed: str,
    file: str | None,
    cause: BaseException | None = None,
) -> NoReturn:
    raise SceneError(problem, file=file, key=key, value=value, allowed=allowed) from cause
