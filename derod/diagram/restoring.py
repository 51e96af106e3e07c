"""A diagram's paths made ready to go on with: points made again, special points looked for again."""

from __future__ import annotations

import numpy as np

from derod.diagram.content import Diagram, StoredPath
from derod.pushing.encode import decode
from derod.rod.state import State
from derod.tracing.arc import Arc, Point, weighed
from derod.tracing.path import Path
from derod.tracing.special import JOINT, Special, specials


def restored(arc: Arc, diagram: Diagram) -> list[Path]:
    """Return the paths of a diagram with points that steps can be taken from."""
    return [restored_path(arc, one, slides=diagram.slides) for one in diagram.paths.values()]


def restored_path(arc: Arc, stored: StoredPath, *, slides: bool) -> Path:
    """Return one path; special points get the fates that they had, those found again by their place."""
    system = arc.system
    states = [decode(system, stored.frame(i), slides=slides) for i in range(len(stored))]
    points: list[Point] = []
    for i, state in enumerate(states):
        point = point_of(arc, states, i, state)
        if point is not None:
            point.arc = float(stored.table["path_arc"][i])
            points.append(point)
    path = Path(stored.name, points, [], stored.begins, stored.ends, stored.whole)
    for row in stored.specials:
        found = found_again(arc, path, row)
        if found is not None:
            found.fate, found.partner = row["fate"].decode(), row["partner"].decode()
            found.symmetric = bool(row["symmetric"])
            path.specials.append(found)
    return path


def point_of(arc: Arc, states: list[State], i: int, state: State) -> Point | None:
    """Return a state as a point, its tangent the way of the path's chord."""
    before, after = states[max(i - 1, 0)], states[min(i + 1, len(states) - 1)]
    arc.system.gradient(state)
    weight = arc.metric(state)
    chord = arc.difference(before, after)
    rate = arc.control.value(after) - arc.control.value(before)
    chord, rate = arc.unit(chord, rate, weight)
    return arc.point(state, weighed(weight, chord), rate)


def found_again(arc: Arc, path: Path, row: np.void) -> Special | None:
    """Return a special point, looked for between the points on its two sides."""
    arcs = np.array([point.arc for point in path.points])
    place = float(row["path_arc"])
    k = int(np.clip(np.searchsorted(arcs, place), 1, len(arcs) - 1))
    a, b = path.points[k - 1], path.points[k]
    if row["kind"].decode() == JOINT:  # behind an end: one step on
        end, sign = (b, 1.0) if place >= arcs[-1] else (a, -1.0)
        beyond = arc.step(end, None, sign * 2 * max(abs(place - end.arc), 1e-3))
        if beyond is None:
            return None
        a, b = (end, beyond) if sign > 0 else (beyond, end)
    near = [one for one in specials(arc, a, b) if one.kind == row["kind"].decode()]
    return min(near, key=lambda one: abs(one.arc - place), default=None)
