"""A traced path, before it is refined and stored."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from derod.branches.half_rod.mirror import Mirror
from derod.branches.paths.arc import Point, Tracer
from derod.branches.paths.special import SpecialPoint


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
