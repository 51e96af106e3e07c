"""What is in a diagram, in lines of text."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from derod.scene.axis import AXES, both

if TYPE_CHECKING:
    from derod.diagram.content import Diagram
    from derod.tracing.arc import Arc
    from derod.tracing.path import Path

HEAD = "  path  points stable modes  E_hat, K0/D        t, K0/D^2"


def diagram_lines(diagram: Diagram) -> Iterator[str]:
    """Yield the paths, where they begin and end, and their special points."""
    axis = AXES[diagram.control]
    words = "complete" if diagram.complete else "not complete (derod explore --resume goes on)"
    yield f"{len(diagram.paths)} paths in the {axis.name}, {words}"
    yield f"{HEAD}{'':12}{axis.symbol}"
    for path in diagram.paths.values():
        table = path.table
        modes = table["unstable_modes"]
        stable = int(np.count_nonzero(modes == 0))
        yield (
            f"  {path.name:5} {len(path):6d} {stable:6d} {int(modes.min())}..{int(modes.max()):<3d}  "
            f"{_span(table['energy_hat']):18} {_span(table['end_tension']):20} "
            f"{axis.both(float(table[diagram.control].min()), 5)} to "
            f"{axis.both(float(table[diagram.control].max()), 5)}"
        )
    for path in diagram.paths.values():
        yield f"{path.name} ({path.character}): {path.begins or '-'} ... {path.ends}"
        for one in path.specials:
            partner, fate = one["partner"].decode(), one["fate"].decode()
            kind = one["kind"].decode()
            if kind == "branch point" and fate:
                kind = "pitchfork" if one["symmetric"] else "transcritical"
            told = f", {partner}" if partner else f", {fate}" if fate else ""
            yield (
                f"  {kind:13} {axis.both(float(one['value']), 9)}, t = {one['end_tension']:.6g}, "
                f"E_hat = {one['energy_hat']:.6g}, modes {one['change']:+d}{told}"
            )


def state_lines(arc: Arc, paths: list[Path], value: float) -> Iterator[str]:
    """Yield the states at an end-shortening by energy, and the saddles between them."""
    from derod.tracing.landscape import passes, states_at

    states = states_at(arc, paths, value)
    yield f"{len(states)} states at {both(value)}, by energy"
    yield "     path  E_hat, K0/D      t, K0/D^2     modes"
    unit = arc.system.bending
    for k, one in enumerate(states):
        here = one.here
        yield (
            f"  {k + 1:2d} {one.path:5} {here.energy_hat * unit:<16.9g} {here.tension * unit:<13.8g} "
            f"{here.unstable_modes}"
        )
    for found in passes(arc, states):
        saddle = states[found.saddle]
        names = [("a minimum that no path has" if k is None else str(k + 1)) for k in found.minima]
        heights = [
            f"{(saddle.here.energy - states[k].here.energy) * unit:.6g}"
            for k in dict.fromkeys(found.minima)
            if k is not None
        ]
        yield (
            f"  saddle {found.saddle + 1} lies between {names[0]} and {names[1]}"
            + (f": barrier {', '.join(heights)} K0/D" if heights else "")
        )


def _span(values: np.ndarray) -> str:
    return f"{np.min(values):.5g} to {np.max(values):.5g}"
