"""A branch: a path's points refined, with their errors and unstable modes, and its special points."""

from __future__ import annotations

from dataclasses import dataclass, field

from derod.branches.half_rod.mesh import halved
from derod.branches.half_rod.mirror import Mirror
from derod.branches.half_rod.observables import observables
from derod.branches.half_rod.state import HalfRod
from derod.branches.paths.arc import Point, Tracer
from derod.branches.paths.error import refined
from derod.branches.paths.path import Path
from derod.branches.paths.special import SpecialPoint
from derod.branches.paths.stability import unstable_modes


@dataclass(frozen=True)
class Stored:
    """A branch's point as it is written: state, numbers, mesh-halving error, label of a special
    point."""

    state: HalfRod
    values: dict[str, float]
    error: float
    label: str = ""
    unstable_modes: int = -1


@dataclass(frozen=True)
class Bifurcation:
    """A special point of a branch: its index among the points, kind, and the branch that leaves
    there."""

    index: int
    kind: str
    partner: str
    function: float


@dataclass
class Branch:
    """A named solution branch."""

    name: str
    even: Mirror
    points: list[Stored]
    bifurcations: list[Bifurcation] = field(default_factory=list)
    begins: str = ""
    ends: str = ""
    remarks: list[str] = field(default_factory=list)  # sign changes that were no zeros


def stored(
    tracer: Tracer, point: Point, label: str = "", count_modes: bool = True, beside: bool = False
) -> Stored:
    """A path's point refined to the wanted accuracy, its unstable modes counted.

    ``beside``: a fold or pitchfork is the next point; a mode is soft, and is counted on elements
    cut in two.
    """
    state, error = refined(tracer, point)
    modes = -1
    if count_modes:
        modes = sum(unstable_modes(halved(state) if beside else state, critical=bool(label)))
    return Stored(state, observables(state), error, label, modes)


def merged(
    points: list[Point], specials: list[tuple[int, SpecialPoint]]
) -> list[tuple[Point, SpecialPoint | None]]:
    """Points and special points in the order of the path's arclength."""
    out: list[tuple[Point, SpecialPoint | None]] = [(p, None) for p in points]
    for _, special in specials:
        out.append((special.point, special))
    out.sort(key=lambda item: item[0].arc)
    return out


def store(path: Path, count_modes: bool = True) -> Branch:
    """A path with every point refined, its error estimated and its unstable modes counted."""
    specials = {id(s): i for i, (_, s) in enumerate(path.specials)}
    rows: list[tuple[Tracer, Point, SpecialPoint | None, str]] = []
    for at_start, tracer, joint, partner in path.joints:
        if at_start:
            rows.append((tracer, joint.point, joint, partner))
    for point, special in merged(path.points, path.specials):
        partner = path.partners.get(specials[id(special)], "") if special else ""
        rows.append((path.tracer, point, special, partner))
    for at_start, tracer, joint, partner in path.joints:
        if not at_start:
            rows.append((tracer, joint.point, joint, partner))
    marked = [special is not None for _, _, special, _ in rows]
    branch = Branch(
        path.name,
        path.tracer.mirror,
        [],
        begins=path.begins,
        ends=path.ends,
        remarks=path.remarks,
    )
    for i, (tracer, point, special, partner) in enumerate(rows):
        if special:
            branch.bifurcations.append(Bifurcation(i, special.kind, partner, special.function))
        label = special.kind if special else ""
        beside = any(marked[max(i - 1, 0) : i + 2])
        branch.points.append(stored(tracer, point, label, count_modes, beside))
    return branch
