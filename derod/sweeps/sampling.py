"""Which points a design makes of the spreads of its keys.

``grid``: every combination, the last key fastest. ``list``: the first values together, then the second, ...
``latin-hypercube`` and ``sobol``: ``scipy.stats.qmc`` (McKay, Beckman, Conover 1979; Sobol' 1967, scrambled
by Owen's method), seeded. ``differences``: the means, then each key a standard deviation up, and down.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from itertools import product
from math import prod

from derod.errors import SceneError
from derod.sweeps.spreads import FORMS, Spread, Value, settled

GRID, LIST, LATIN, SOBOL = "grid", "list", "latin-hypercube", "sobol"
DIFFERENCES = "differences"
DESIGNS = (GRID, LIST, LATIN, SOBOL, DIFFERENCES)
SAMPLED = (LATIN, SOBOL)
MOST_POINTS = 1_000_000
Point = tuple[Value, ...]
"""The values of one point, in the order of the keys."""


def check_design(
    design: object, spreads: Sequence[Spread], points: object, file: str | None
) -> int:
    """The number of points. Raises SceneError where the design does not fit its keys."""
    if design not in DESIGNS:
        raise SceneError("is no design", file=file, key="design.kind", value=design,
                         allowed=", ".join(DESIGNS))  # fmt: skip
    if not spreads:
        raise SceneError("is empty: nothing varies", file=file, key="keys", allowed=FORMS)
    for spread in spreads:
        if design in SAMPLED and not spread.is_distribution:
            raise SceneError(f"is a list, of which {design} cannot draw", file=file, key=spread.key,
                             allowed="{from, to} or {normal = [mean, deviation]}")  # fmt: skip
        if design == DIFFERENCES and not math.isfinite(spread.mean):
            raise SceneError("has no standard deviation", file=file, key=spread.key,
                             allowed="{normal = [mean, deviation]}, or '5.6 +- 0.5 um'")  # fmt: skip
        if design in (GRID, LIST) and not spread.values:
            raise SceneError(f"has no values for a {design}", file=file, key=spread.key,
                             allowed="a list, or {from, to, count}")  # fmt: skip
    if design in SAMPLED:
        whole = isinstance(points, int) and not isinstance(points, bool)
        count = points if isinstance(points, int) and whole else 0
        if not 1 <= count <= MOST_POINTS:
            raise SceneError("is no number of points", file=file, key="design.points", value=points,
                             allowed=f"1 to {MOST_POINTS}")  # fmt: skip
        return count
    if points is not None:
        raise SceneError(f"is given, and the {design} has its own number of points", file=file,
                         key="design.points", value=points,
                         allowed=f"with {' or '.join(SAMPLED)}")  # fmt: skip
    if design == DIFFERENCES:
        return 1 + 2 * len(spreads)
    counts = [len(spread.values) for spread in spreads]
    if design == LIST and len(set(counts)) > 1:
        told = ", ".join(f"{s.key}: {n}" for s, n in zip(spreads, counts, strict=True))
        raise SceneError(f"makes lists of different lengths ({told})", file=file, key="keys",
                         allowed="as many values for each key")  # fmt: skip
    count = counts[0] if design == LIST else prod(counts)
    if count > MOST_POINTS:
        raise SceneError(f"makes {count} points", file=file, key="keys",
                         allowed=f"at most {MOST_POINTS}")  # fmt: skip
    return count


def points_of(design: str, spreads: Sequence[Spread], count: int, seed: int) -> Iterator[Point]:
    """The points in their order, of a design that was checked."""
    if design == GRID:
        return product(*(spread.values for spread in spreads))
    if design == LIST:
        return zip(*(spread.values for spread in spreads), strict=True)
    if design == DIFFERENCES:
        return _differences(spreads)
    return _drawn(design, spreads, count, seed)


def _differences(spreads: Sequence[Spread]) -> Iterator[Point]:
    means = [spread.mean for spread in spreads]
    yield tuple(means)
    for k, spread in enumerate(spreads):
        for sign in (1.0, -1.0):
            yield (*means[:k], spread.mean + sign * spread.deviation, *means[k + 1 :])


def _drawn(design: str, spreads: Sequence[Spread], count: int, seed: int) -> Iterator[Point]:
    from scipy.stats import qmc

    if design == SOBOL:
        sampler = qmc.Sobol(len(spreads), rng=seed)
        bits = max(count - 1, 0).bit_length()
        shares = sampler.random_base2(bits)[:count]  # balanced where count is a power of 2
    else:
        shares = qmc.LatinHypercube(len(spreads), rng=seed).random(count)
    columns = [settled(s.key, s.draw(shares[:, k])) for k, s in enumerate(spreads)]
    return zip(*columns, strict=True)
