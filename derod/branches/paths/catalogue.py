"""The paper's paths by name, each found from the straight rod without a guess.

Ax: planar, from the straight rod's buckling. 3D: leaves Ax at its first pitchfork (end rotation
0) or the twisted straight rod (end rotation 2 pi). L1, L2, ...: planar loops that a 3D path
meets; 3D after L_j is named 3D-Lj. Pt: point-symmetric planar curve, reached from large f_gamma.
Tri1, Tri2, ...: space paths of higher energy from the other pitchforks of Ax. 3D-K2: with two bending
stiffnesses, the path of what the round rod's 3D becomes, where no other path has it. With a weight there
is no Pt; Ax, 3D, ... begin with the hanging rod, Ax-up, 3D-up, ... with the one upside down.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np

from derod.branches.half_rod import closure as col
from derod.branches.half_rod.mirror import (
    FULL,
    LOOP_EVEN,
    LOOP_ODD,
    S_EVEN,
    S_ODD,
    STRAIGHT_LOOP,
    STRAIGHT_TWISTED,
    Mirror,
)
from derod.branches.half_rod.observables import loops
from derod.branches.half_rod.outcome import NotConverged
from derod.branches.half_rod.parameters import Parameters
from derod.branches.paths.arc import Control, Point, Tracer
from derod.branches.paths.beginning import buckled, loaded_start
from derod.branches.paths.branch import Branch, store
from derod.branches.paths.joints import flattened, nearest_joint, stop_in_plane
from derod.branches.paths.newton import Settled
from derod.branches.paths.path import Path, PathNotFound
from derod.branches.paths.point_symmetric import point_symmetric_state
from derod.branches.paths.special import branch_off
from derod.branches.paths.stiff_path import stiffened_path
from derod.branches.paths.tracing import (
    collect,
    end_reason,
    finish_at_end,
    special_points,
    two_ways,
)

SUCCESSION_LIMIT = 20
UPSIDE_DOWN = "-up"
"""Ending of the names of a heavy drop's paths that start from the rod turned by pi."""
TRIANGLES = 3
"""Most 'yet other paths' followed from Ax."""


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

    def ax(self) -> Path:
        """The planar path from the straight rod's first buckling, through its folds to its end."""
        name = "Ax" + self.ending
        if name not in self.paths:
            self._from_straight(name, STRAIGHT_LOOP, LOOP_EVEN, LOOP_ODD)
        return self.paths[name]

    def _from_straight(self, name: str, mode: Mirror, mirror: Mirror, odd: Mirror | None) -> Path:
        usual = end_reason(self.delta_limit)
        stop: Callable[[Point], object] = stop_in_plane(self.delta_limit) if odd is None else usual
        if self.parameters.weight != 0.0:
            settled = loaded_start(
                self.parameters, self.control, mode, mirror, upside_down=self.upside_down
            )
            path, reason = self._both_ways(name, mirror, odd, settled, stop)
            self.paths[name] = path
            self._join(path, reason)
            return path
        tracer, start, tension = buckled(self.parameters, self.control, mode, mirror)
        points, reason = collect(tracer, start, stop)
        path = Path(name, tracer, odd, points, begins=f"straight rod, t = {tension:.6f}")
        self.paths[name] = path
        self._close(path, reason)
        return path

    def _both_ways(
        self,
        name: str,
        mirror: Mirror,
        odd: Mirror | None,
        settled: Settled,
        stop: Callable[[Point], object],
    ) -> tuple[Path, object]:
        """The path through a settled state, and what ``stop`` said at its end of growing delta."""
        tracer = self.tracer(mirror)
        remarks: list[str] = []
        usual = end_reason(self.delta_limit)
        found = two_ways(tracer, settled, odd, remarks, stop, usual)
        path = Path(name, tracer, odd, found.points, found.specials, found.begins, remarks=remarks)
        if isinstance(found.ends, str):
            path.ends = found.ends
        return path, found.ends

    def _close(self, path: Path, reason: object) -> None:
        """Finish a path: its end state or its joint with a plane, then its special points."""
        if isinstance(reason, str):
            path.ends = reason
            finish_at_end(path.tracer, path.points)
        else:
            self._join(path, reason)
        path.specials = special_points(path.tracer, path.points, path.odd, path.remarks)

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
        return tracer, *collect(
            tracer, tracer.begin(settled, outward), stop_in_plane(self.delta_limit)
        )

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
        known = nearest_joint(self.paths.values(), even, flat.state)
        if known is None:
            head = f"L{round(loops(flat.state))}" if even.name != S_EVEN.name else "S"
            while head + self.ending in self.paths:
                head += "'"
            name = head + self.ending
            usual = end_reason(self.delta_limit)
            self.paths[name] = self._both_ways(name, even, odd, flat, usual)[0]
            known = nearest_joint(self.paths.values(), even, flat.state, np.inf)
            if known is None:
                path.ends = f"met {name}, where no pitchfork was found"
                return
        planar, number, joint = known
        name = planar.name
        planar.partners[number] = path.name
        path.joints.append((False, planar.tracer, joint, name))
        path.ends = f"pitchfork of {name}"
        path.points.pop()

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
        yield from self._onward(path)

    def _onward(self, path: Path) -> Iterator[Path]:
        """L_j, 3D-Lj, L_k, ...: the paths that a space path leads to."""
        for _ in range(SUCCESSION_LIMIT):
            if len(path.joints) == 0 or path.joints[-1][0]:
                return
            planar = self.paths[path.joints[-1][3]]
            yield planar
            arrival = path.joints[-1][2]
            later = [
                item for item in planar.pitchforks if item[1].point.arc > arrival.point.arc + 1e-9
            ]
            if not later or f"3D-{planar.name}" in self.paths:
                return
            path = self.space_path(f"3D-{planar.name}", planar, later[0][0])
            yield path

    def pt(self) -> Path:
        """The point-symmetric planar path, by lowering f_gamma at fixed end-shortening."""
        if "Pt" not in self.paths:
            settled = point_symmetric_state(self.parameters, self.control)
            usual = end_reason(self.delta_limit)
            self.paths["Pt"], _ = self._both_ways("Pt", S_EVEN, S_ODD, settled, usual)
        return self.paths["Pt"]

    def stiff(self) -> Iterator[Path]:
        """The path of what the round rod's 3D becomes as K2/K1 changes, if no other path has it.

        Of weightless drops only.
        """
        if not self.parameters.anisotropic or self.parameters.weight != 0.0:
            return
        origin = next(Catalogue(self.parameters.isotropic, self.control).succession(), None)
        if origin is None:
            raise PathNotFound("3D-K2: the round rod has no path 3D")
        known, tracer = self.paths.values(), self.tracer(FULL)
        found = stiffened_path(origin, self.parameters, tracer, known, self.delta_limit)
        if found is not None:
            path, reason = found
            self.paths[path.name] = path
            self._join(path, reason)
            yield path
            yield from self._onward(path)

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

    def store(self, path: Path, count_modes: bool = True) -> Branch:
        """A path with every point refined, its error estimated and its unstable modes counted."""
        return store(path, count_modes)
