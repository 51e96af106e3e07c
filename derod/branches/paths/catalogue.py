"""The paper's paths by name, each found from the straight rod without a guess.

Ax: planar, from the straight rod's buckling. 3D: leaves Ax at its first pitchfork (end rotation
0) or the twisted straight rod (end rotation 2 pi). L1, L2, ...: planar loops that a 3D path
meets; 3D after L_j is named 3D-Lj. Pt: point-symmetric planar curve, reached from large f_gamma.
Tri1, Tri2, ...: space paths of higher energy from the other pitchforks of Ax.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace

import numpy as np

from derod.branches.half_rod import closure as col
from derod.branches.half_rod.mirror import (
    FULL,
    LOOP_EVEN,
    LOOP_ODD,
    S_EVEN,
    S_ODD,
    STRAIGHT_LOOP,
    STRAIGHT_S,
    STRAIGHT_TWISTED,
    Mirror,
)
from derod.branches.half_rod.observables import loops
from derod.branches.half_rod.outcome import NotConverged
from derod.branches.half_rod.parameters import Parameters
from derod.branches.half_rod.state import HalfRod
from derod.branches.paths.arc import Control, Point, Tracer, frozen
from derod.branches.paths.branch import (
    Bifurcation,
    Branch,
    collect,
    end_reason,
    finish_at_end,
    merged,
    reversed_path,
    special_points,
    stored,
)
from derod.branches.paths.newton import Settled, settle
from derod.branches.paths.special import SpecialPoint, branch_off, crossed_plane, flattened
from derod.branches.paths.straight import NoBuckling, buckling_tensions, first_buckled
from derod.branches.paths.weight import START, hung, loaded

AMPLITUDE = 0.02
"""Lateral offset (D) or quaternion component held in the first buckled state."""
SUCCESSION_LIMIT = 20
PT_END_SHORTENING = 1.1 * math.pi
"""Where f_gamma is lowered on Pt."""
PT_FACTORS = (1.0, 1.5, 2.0, 3.0, 4.0, 6.0, 8.0, 12.0)
"""Multiples of f_gamma at which the second buckling mode is looked for."""
JOINT_DISTANCE = 0.1
"""A plane met is one already traced if (delta, t/f_gamma, sigma) are this near to its pitchfork."""
UPSIDE_DOWN = "-up"
"""Ending of the names of a heavy drop's paths that start from the rod turned by pi."""
TRIANGLES = 3
"""Most 'yet other paths' followed from Ax."""


class PathNotFound(ArithmeticError):  # noqa: N818 - the command line answers it with exit code 3
    """A named path could not be found or continued as it should."""


@dataclass
class Path:
    """A traced path before it is stored."""

    name: str
    tracer: Tracer
    odd: Mirror | None
    points: list[Point]
    specials: list[tuple[int, SpecialPoint]] = field(default_factory=list)
    begins: str = ""
    ends: str = ""
    remarks: list[str] = field(default_factory=list)
    partners: dict[int, str] = field(default_factory=dict)  # index among specials -> branch
    joints: list[tuple[bool, Tracer, SpecialPoint, str]] = field(default_factory=list)
    # (at the start, tracer of the planar path, its pitchfork, its name)

    @property
    def pitchforks(self) -> list[tuple[int, SpecialPoint]]:
        """Indices among the specials, and pitchforks, in the path's order."""
        return [(i, s) for i, (_, s) in enumerate(self.specials) if s.kind == "pitchfork"]

    @property
    def pitchforks_ahead(self) -> list[tuple[int, SpecialPoint]]:
        """Those behind the last fold before the path's arclength 0.

        A rod with its drop upside down comes from large end-shortenings under pressure, and turns round
        where it may be pulled.
        """
        turns = [s.point.arc for _, s in self.specials if s.kind == "fold" and s.point.arc < 0.0]
        return [item for item in self.pitchforks if item[1].point.arc > max(turns, default=-np.inf)]


class Catalogue:
    """Finds and keeps the paths of one set of parameters.

    ``delta_limit`` (D) bounds the end-shortening; paths of interest end earlier, where the outer
    rod runs out. With a weight the paths start from the hanging rod or, ``upside_down``, from the one
    turned by pi; the latter's names end with "-up".
    """

    def __init__(
        self,
        parameters: Parameters,
        control: Control | None = None,
        delta_limit: float | None = None,
        upside_down: bool = False,
    ) -> None:
        self.parameters = parameters
        self.upside_down = upside_down
        self.ending = UPSIDE_DOWN if upside_down else ""
        self.control = control or Control()
        self.delta_limit = parameters.length if delta_limit is None else delta_limit
        self.paths: dict[str, Path] = {}
        self.missed: list[str] = []  # paths that could not be followed, and why

    def tracer(self, mirror: Mirror, held: tuple[int, ...] = (col.FGAMMA,)) -> Tracer:
        """A tracer of this catalogue's control in a mirror class."""
        return Tracer(mirror, self.control, self.parameters.capillary_force, held)

    @property
    def twisted(self) -> bool:
        """Whether the straight rod is twisted (end rotation not a multiple of 4 pi: all start as
        one)."""
        return self.parameters.end_rotation != 0.0

    # --- paths -----------------------------------------------------------------------------------

    def ax(self) -> Path:
        """The planar path from the straight rod's first buckling, through its folds to its end."""
        name = "Ax" + self.ending
        if name not in self.paths:
            self._from_straight(name, STRAIGHT_LOOP, LOOP_EVEN, LOOP_ODD)
        return self.paths[name]

    def _from_straight(self, name: str, mode: Mirror, mirror: Mirror, odd: Mirror | None) -> Path:
        if self.parameters.weight != 0.0:
            settled = self._loaded_start(mode, mirror)
            stop = self._stop_in_plane() if odd is None else None
            path, reason = self._both_ways(name, mirror, odd, settled, stop)
            self.paths[name] = path
            if not isinstance(reason, str):
                self._join(path, reason)
            return path
        tracer, start, tension = self.buckled(mode, mirror)
        stop = self._stop_in_plane() if odd is None else end_reason(self.delta_limit)
        points, reason = collect(tracer, start, stop)
        path = Path(name, tracer, odd, points, begins=f"straight rod, t = {tension:.6f}")
        self.paths[name] = path
        self._close(path, reason)
        return path

    def buckled(self, mode: Mirror, mirror: Mirror) -> tuple[Tracer, Point, float]:
        """The first point of the path that leaves the straight rod, and the buckling tension."""
        control = self.control
        tension = buckling_tensions(self.parameters, mode)[0]
        held = col.NODE_0 + 1
        settled = first_buckled(
            self.parameters,
            tension,
            mode,
            mirror,
            held,
            AMPLITUDE,
            control.tolerance,
            control.resolution,
        )
        tracer = self.tracer(mirror)
        return tracer, tracer.begin(settled, frozen(held)), tension

    def _loaded_start(self, mode: Mirror, mirror: Mirror) -> Settled:
        """A state of the heavy drop, on the path that starts as the straight rod's buckling."""
        tracer, start, _ = self.buckled(mode, mirror)
        missed = []
        for delta in START:
            goal = min(delta, 0.5 * (self.parameters.length - 1.0))
            points, _ = collect(tracer, start, end_reason(goal))
            state = hung(points[-1].state, start.state, upside_down=self.upside_down)
            try:
                return loaded(state, self.parameters.weight, mirror, self.control)[0]
            except NotConverged as error:
                missed.append(str(error))
        raise PathNotFound("; ".join(missed))

    def _close(self, path: Path, reason: object) -> None:
        """Finish a path: its end state or its joint with a plane, then its special points."""
        if isinstance(reason, str):
            path.ends = reason
            finish_at_end(path.tracer, path.points)
        else:
            self._join(path, reason)
        path.specials = special_points(path.tracer, path.points, path.odd, path.remarks)

    def _stop_in_plane(self) -> Callable[[Point], object]:
        """Stop where a space path crosses a plane, or for the usual reasons."""
        before: list[Point] = []
        usual = end_reason(self.delta_limit)

        def stop(point: Point) -> object:
            crossed = crossed_plane(before[-1].state, point.state) if before else None
            before[:] = [point]
            return crossed or usual(point)

        return stop

    def space_path(self, name: str, origin: Path, number: int, side: float = 1.0) -> Path:
        """The path that leaves a planar one at its special point ``number``, up to the next
        plane."""
        special = origin.specials[number][1]
        tracer, points, reason = self.leave(origin, number, side)
        path = Path(name, tracer, None, points, begins=f"pitchfork of {origin.name}")
        self.paths[name] = path
        path.joints.append((True, origin.tracer, special, origin.name))
        origin.partners[number] = name
        self._close(path, reason)
        return path

    def leave(
        self, origin: Path, number: int, side: float = 1.0
    ) -> tuple[Tracer, list[Point], object]:
        """The points of ``space_path``, and the plane crossed or the reason of its end."""
        settled, outward = branch_off(origin.specials[number][1], self.control.tolerance, side)
        tracer = self.tracer(FULL)
        return tracer, *collect(tracer, tracer.begin(settled, outward), self._stop_in_plane())

    def _join(self, path: Path, reason: object) -> None:
        """If a space path ended in a plane, trace the planar path there and cut the space path at
        it."""
        if not isinstance(reason, tuple):
            return
        even, odd = reason
        try:
            flat = flattened(path.points[-1].state, even, self.control.tolerance)
        except NotConverged as error:
            path.ends = f"met a plane, but no planar state was found there: {error}"
            return
        known = self._nearest_joint(even, flat.state, JOINT_DISTANCE)
        if known is None:
            name = f"L{round(loops(flat.state))}" if even.name != S_EVEN.name else "S"
            name += self.ending
            while name in self.paths:
                name += "'"
            planar = self.paths[name] = self._both_ways(name, even, odd, flat)[0]
            known = self._nearest_joint(even, flat.state, np.inf)
            if known is None:
                path.ends = f"met {name}, where no pitchfork was found"
                return
        planar, number, joint = known
        name = planar.name
        planar.partners[number] = path.name
        path.joints.append((False, planar.tracer, joint, name))
        path.ends = f"pitchfork of {name}"
        path.points.pop()

    def _nearest_joint(
        self, even: Mirror, state: HalfRod, limit: float
    ) -> tuple[Path, int, SpecialPoint] | None:
        """The pitchfork of a planar path already traced that lies at a planar state, if any.

        A plane turned by pi has the same numbers, so numbers are compared and not unknowns.
        """
        here = np.array([state.end_shortening, state.end_tension / state.scalars[5], state.sigma])
        best, nearest = None, limit
        for planar in self.paths.values():
            if planar.tracer.mirror is not even:
                continue
            for number, special in planar.pitchforks:
                there = special.point.state
                numbers = [there.end_shortening, there.end_tension / there.scalars[5], there.sigma]
                distance = float(np.abs(here - numbers).max())
                if distance < nearest:
                    best, nearest = (planar, number, special), distance
        return best

    def _both_ways(
        self,
        name: str,
        even: Mirror,
        odd: Mirror | None,
        settled: Settled,
        stop: Callable[[Point], object] | None = None,
    ) -> tuple[Path, object]:
        """A path through a settled state, its points in the sense of growing delta there.

        ``stop``: the stop test that way, ``end_reason`` by default; its reason is returned too.
        """
        tracer = self.tracer(even)
        forward = frozen(col.DELTA)
        usual = end_reason(self.delta_limit)
        up, end = collect(tracer, tracer.begin(settled, forward), stop or usual)
        down, begin = collect(tracer, tracer.begin(settled, -forward), usual)
        finish_at_end(tracer, up)
        finish_at_end(tracer, down)
        path = Path(name, tracer, odd, reversed_path(down)[:-1] + up, begins=str(begin))
        path.ends = end if isinstance(end, str) else ""
        specials = special_points(tracer, down, odd, path.remarks)
        back = [
            (i, replace(s, point=Point(s.point.settled, -s.point.tangent, -s.point.arc)))
            for i, s in reversed(specials)
        ]
        ahead = [(i + len(down) - 1, s) for i, s in special_points(tracer, up, odd, path.remarks)]
        path.specials = [*back, *ahead]
        return path, end

    def succession(self) -> Iterator[Path]:
        """3D, L_j, 3D-Lj, L_k, ...: the paths of lowest energy, until the outer rod runs out."""
        if self.twisted:
            path = self._from_straight("3D" + self.ending, STRAIGHT_TWISTED, FULL, None)
        else:
            origin = self.ax()
            if not origin.pitchforks_ahead:
                return
            path = self.space_path("3D" + self.ending, origin, origin.pitchforks_ahead[0][0])
        yield path
        for _ in range(SUCCESSION_LIMIT):
            if len(path.joints) == 0 or path.joints[-1][0]:
                return
            planar = self.paths[path.joints[-1][3]]
            yield planar
            arrival = path.joints[-1][2]
            later = [
                item for item in planar.pitchforks if item[1].point.arc > arrival.point.arc + 1e-9
            ]
            if not later:
                return
            path = self.space_path(f"3D-{planar.name}", planar, later[0][0])
            yield path

    def pt(self) -> Path:
        """The point-symmetric planar path, by lowering f_gamma at fixed end-shortening."""
        if "Pt" in self.paths:
            return self.paths["Pt"]
        target = self.parameters.capillary_force
        for factor in PT_FACTORS:
            strong = self.parameters.with_capillary_force(factor * target)
            try:
                tension = buckling_tensions(strong, STRAIGHT_S)[0]
            except NoBuckling:
                continue
            break
        else:
            raise PathNotFound(
                "Pt: the straight rod's second mode does not buckle at any f_gamma tried"
            )
        control = self.control
        held = col.NODE_0 + 5
        settled = first_buckled(
            strong,
            tension,
            STRAIGHT_S,
            S_EVEN,
            held,
            AMPLITUDE,
            control.tolerance,
            control.resolution,
        )
        tracer = self.tracer(S_EVEN)
        goal = min(PT_END_SHORTENING, 0.5 * (self.parameters.length - 1.0))
        points, _ = collect(
            tracer,
            tracer.begin(settled, frozen(held)),
            lambda p: "there" if p.state.end_shortening > goal else end_reason(goal)(p),
        )
        if points[-1].state.end_shortening <= goal:
            raise PathNotFound(
                "Pt: the second mode's path does not reach the end-shortening wanted"
            )
        lowering = self.tracer(S_EVEN, held=(col.DELTA,))
        points, _ = collect(
            lowering,
            lowering.begin(points[-1].settled, -frozen(col.FGAMMA)),
            lambda p: "there" if p.state.scalars[5] <= target else None,
        )
        if points[-1].state.scalars[5] > target:
            raise PathNotFound("Pt: f_gamma could not be lowered to the scene's")
        state = points[-1].state.set_scalar(col.FGAMMA, target)
        closing = np.stack([frozen(col.FGAMMA), frozen(col.DELTA)])
        values = np.array([target, state.end_shortening])
        state = replace(state, parameters=self.parameters)
        settled = settle(state, S_EVEN, closing, values, control.tolerance, 20)
        self.paths["Pt"], _ = self._both_ways("Pt", S_EVEN, S_ODD, settled)
        return self.paths["Pt"]

    def triangles(self) -> Iterator[Path]:
        """'Yet other paths': space paths from the pitchforks of Ax behind the first."""
        origin = self.ax()
        count = 0
        for number, _ in origin.pitchforks_ahead[1:]:
            if number in origin.partners or count == TRIANGLES:
                continue
            count += 1
            try:
                path = self.space_path(f"Tri{count}{self.ending}", origin, number)
            except NotConverged as error:
                self.missed.append(f"Tri{count}{self.ending}: {error}")
                continue
            yield path

    # --- results ---------------------------------------------------------------------------------

    def store(self, path: Path, count_modes: bool = True) -> Branch:
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
