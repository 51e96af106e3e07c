"""Paths that several tests look at, traced once."""

from __future__ import annotations

import functools

from derod.equilibrium.system import System
from derod.pushing.controls import CONTROLS
from derod.tracing.arc import Arc
from derod.tracing.path import Limits, Path, follow
from derod.tracing.special import BRANCH_POINT
from derod.tracing.straight import buckled, bucklings
from derod.tracing.switching import switch
from tests.scenes import coil


@functools.cache
def planar(edges: int = 200) -> tuple[Arc, Path]:
    """Ax, the first planar path, through both of its folds."""
    arc = Arc(System(coil(edges=edges)), CONTROLS["end_shortening"])
    first = buckled(arc, bucklings(arc.system, 1)[0])
    assert first is not None
    return arc, follow(arc, first, Limits(), "Ax")


@functools.cache
def side(index: int) -> Path:
    """What leaves Ax at one of its branch points."""
    arc, path = planar()
    special = [one for one in path.specials if one.kind == BRANCH_POINT][index]
    first = switch(arc, special)
    assert first is not None
    return follow(arc, first, Limits(), f"side {index}")
