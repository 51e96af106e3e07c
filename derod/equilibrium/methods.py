"""The methods by their names in a scene file."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

from derod.equilibrium.elliptic import Elliptic
from derod.equilibrium.explicit import Explicit
from derod.equilibrium.implicit import Implicit
from derod.equilibrium.loop import Relaxer

METHODS: dict[str, Callable[[], Relaxer]] = {
    "implicit": Implicit,
    "elliptic": Elliptic,
    "fire": partial(Explicit, kinetic=False),
    "kinetic": partial(Explicit, kinetic=True),
}


def make_relaxer(name: str) -> Relaxer:
    """Return the relaxer that a scene names (``relax.method``)."""
    return METHODS[name]()
