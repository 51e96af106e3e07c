"""Exudyn on the clamped-clamped elastica: cables of the absolute nodal coordinate formulation in the plane.

The end's place is a constraint whose offset follows the load factor; a load across the middle in the first
step starts the buckling. Cables stretch: the axial stiffness is a setting.
"""

from __future__ import annotations

import itertools
from typing import NamedTuple

import exudyn
from exudyn.itemInterface import NodePoint2DSlope1
from exudyn.utilities import (
    CoordinateConstraint,
    Force,
    MarkerNodeCoordinate,
    MarkerNodePosition,
    NodePointGround,
    ObjectANCFCable2D,
)

from bench.elastica import SHORTENING

PUSH = 20.0  # K/L^2, across the middle, at first


class Settings(NamedTuple):
    """What is scanned."""

    elements: int
    steps: int = 10
    stiffness: float = 1e5  # EA, K/L^2
    solver: str = "EXUdense"

    def __str__(self) -> str:
        return f"{self.steps} steps, {self.solver}, EA {self.stiffness:.0e}"


SCAN = [
    Settings(elements, steps, stiffness, solver)
    for stiffness in (1e4, 1e5, 1e6)
    for solver in ("EXUdense", "EigenSparse")
    for steps in (2, 4, 7, 10, 20)
    for elements in (8, 16, 32, 64)
]


class Answer(NamedTuple):
    """What it settled into."""

    iterations: int
    tension: float  # K/L^2
    height: float  # L


def solve(settings: Settings) -> Answer | None:
    """Push from the straight rod; None where a step does not converge."""
    n = settings.elements
    container = exudyn.SystemContainer()
    system = container.AddSystem()
    ground = system.AddMarker(
        MarkerNodeCoordinate(nodeNumber=system.AddNode(NodePointGround()), coordinate=0)
    )
    nodes = [
        system.AddNode(NodePoint2DSlope1(referenceCoordinates=[i / n, 0.0, 1.0, 0.0]))
        for i in range(n + 1)
    ]
    for one, two in itertools.pairwise(nodes):
        system.AddObject(
            ObjectANCFCable2D(
                nodeNumbers=[one, two], physicsLength=1 / n, physicsMassPerLength=1.0,
                physicsBendingStiffness=1.0, physicsAxialStiffness=settings.stiffness,
                useReducedOrderIntegration=1,
            )
        )  # fmt: skip
    first = 1 / settings.steps

    def held(node: int, coordinate: int, **more) -> int:
        marker = system.AddMarker(MarkerNodeCoordinate(nodeNumber=node, coordinate=coordinate))
        return system.AddObject(CoordinateConstraint(markerNumbers=[ground, marker], **more))

    for coordinate in (0, 1, 3):
        held(nodes[0], coordinate)
    for coordinate in (1, 3):
        held(nodes[-1], coordinate)

    def offset(mbs, t, item, value):
        return -SHORTENING * t

    end = held(nodes[-1], 0, offset=0.0, offsetUserFunction=offset)

    def across(mbs, t, vector):
        return [0.0, PUSH if t < 1.01 * first else 0.0, 0.0]

    middle = system.AddMarker(MarkerNodePosition(nodeNumber=nodes[n // 2]))
    system.AddLoad(Force(markerNumber=middle, loadVector=[0, 0, 0], loadVectorUserFunction=across))
    system.Assemble()
    options = exudyn.SimulationSettings()
    options.staticSolver.numberOfLoadSteps = settings.steps
    options.staticSolver.adaptiveStep = False
    options.staticSolver.loadStepDuration = 1.0
    options.staticSolver.verboseMode = 0
    options.staticSolver.newton.maxIterations = 60
    options.staticSolver.newton.relativeTolerance = 1e-9
    options.staticSolver.newton.absoluteTolerance = 1e-9
    options.linearSolverType = getattr(exudyn.LinearSolverType, settings.solver)
    options.solutionSettings.writeSolutionToFile = False
    options.displayComputationTime = False
    solver = exudyn.MainSolverStatic()
    if not solver.SolveSystem(system, options):
        return None
    force = system.GetObjectOutput(end, exudyn.OutputVariableType.Force)
    place = system.GetNodeOutput(nodes[n // 2], exudyn.OutputVariableType.Position)
    return Answer(int(solver.it.newtonStepsCount), -abs(float(force)), abs(float(place[1])))
