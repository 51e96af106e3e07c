"""A traced path, before it is refined and stored."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np

from derod.branches.half_rod.mirror import Mirror
from derod.branches.half_rod.outcome import NotConverged
from derod.branches.half_rod.state import HalfRod
from derod.branches.paths.arc import Point, Tracer
from derod.branches.paths.special import SpecialPoint, SpuriousPoint, locate


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

    def landings(self, delta: float) -> Iterator[HalfRod]:
        """The states of the path at an end-shortening (D)."""
        for left, right in pairwise(self.points):
            a, b = left.state.end_shortening - delta, right.state.end_shortening - delta
            if a * b < 0.0 or a == 0.0:
                try:
                    yield locate(
                        self.tracer,
                        left,
                        right,
                        lambda p: p.state.end_shortening - delta,
                        "landing",
                    ).point.state
                except (NotConverged, SpuriousPoint):
                    continue
