"""OpenSees (openseespy) on the clamped-clamped elastica: corotational elastic beam-columns in the plane.

Two ways to the end-shortening are scanned. "imposed": the end's place is imposed in steps, with a load across
the middle in the first one. "load": an axial load, controlled by the middle's height (DisplacementControl),
with a small load across it, up to REACH; then without that, controlled by the end's place. Beams stretch:
the axial stiffness is a setting too, since a large one costs digits and iterations, and a small one shortens
the rod by P/EA.
"""

from __future__ import annotations

from typing import NamedTuple

import openseespy.opensees as ops

from bench.elastica import SHORTENING

EULER = 39.4784176  # K/L^2, the reference load
REACH = 0.25  # L, of the middle's height


class Settings(NamedTuple):
    """What is scanned."""

    elements: int
    steps: int = 3
    system: str = "BandGeneral"
    algorithm: str = "Newton"
    stiffness: float = 1e6  # EA, K/L^2
    way: str = "load"

    def __str__(self) -> str:
        return f"{self.way}, {self.steps} steps, {self.system}, {self.algorithm}, EA {self.stiffness:.0e}"


SCAN = [
    Settings(elements, steps, system, algorithm, stiffness, way)
    for way, many in (("load", (1, 2, 3)), ("imposed", (4, 10)))
    for stiffness in (1e5, 1e6, 1e7)
    for algorithm in ("Newton", "NewtonLineSearch", "KrylovNewton")
    for system in ("BandGeneral", "ProfileSPD", "UmfPack")
    for steps in many
    for elements in (50, 100, 200, 400)
]


class Answer(NamedTuple):
    """What it settled into."""

    iterations: int
    tension: float  # K/L^2, of the end clamp
    height: float  # L, of the middle


def solve(settings: Settings) -> Answer | None:
    """Push from the straight rod; None where a step does not converge."""
    n = settings.elements
    build(settings)
    if settings.way == "load":
        iterations = by_load(settings)
        tension = -EULER * ops.getTime()
    else:
        iterations = by_place(settings)
        ops.reactions()
        tension = ops.nodeReaction(n + 1, 1)
    return iterations and Answer(iterations, tension, abs(ops.nodeDisp(n // 2 + 1, 2)))


def build(settings: Settings) -> None:
    """Lay the straight rod between its clamps, the end free to slide."""
    n = settings.elements
    ops.wipe()
    ops.model("basic", "-ndm", 2, "-ndf", 3)
    for i in range(n + 1):
        ops.node(i + 1, i / n, 0.0)
    ops.fix(1, 1, 1, 1)
    ops.fix(n + 1, 0, 1, 1)
    ops.geomTransf("Corotational", 1)
    for i in range(n):
        ops.element("elasticBeamColumn", i + 1, i + 1, i + 2, settings.stiffness, 1.0, 1.0, 1)
    ops.timeSeries("Linear", 1)
    ops.pattern("Plain", 1, 1)
    ops.constraints("Transformation")
    ops.numberer("Plain")
    ops.system(settings.system)
    ops.test("NormDispIncr", 1e-9, 60, 0)
    ops.algorithm(settings.algorithm)


def advance(steps: int) -> int | None:
    """Take steps; return the iterations, None where one does not converge."""
    iterations = 0
    for _ in range(steps):
        if ops.analyze(1) != 0:
            return None
        iterations += ops.testIter()
    return iterations


def by_load(settings: Settings) -> int | None:
    """Buckle by an axial load, and end at the end-shortening."""
    n = settings.elements
    middle = n // 2 + 1
    ops.load(n + 1, -EULER, 0.0, 0.0)
    ops.timeSeries("Constant", 2)
    ops.pattern("Plain", 2, 2)
    ops.load(middle, 0.0, 1.0, 0.0)
    ops.integrator("DisplacementControl", middle, 2, REACH / settings.steps)
    ops.analysis("Static")
    first = advance(settings.steps)
    if first is None:
        return None
    ops.remove("loadPattern", 2)
    ops.integrator("DisplacementControl", n + 1, 1, -SHORTENING - ops.nodeDisp(n + 1, 1))
    last = advance(1)
    return None if last is None else first + last


def by_place(settings: Settings) -> int | None:
    """Impose the end's place in equal steps."""
    n, first = settings.elements, 1 / settings.steps
    ops.sp(n + 1, 1, -SHORTENING)
    times = (0.0, first, 1.5 * first, 1e3)
    ops.timeSeries("Path", 2, "-time", *times, "-values", 0.0, 1.0, 0.0, 0.0)
    ops.pattern("Plain", 2, 2)
    ops.load(n // 2 + 1, 0.0, 20.0, 0.0)
    ops.integrator("LoadControl", first)
    ops.analysis("Static")
    return advance(settings.steps)
