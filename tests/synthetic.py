"""A push without physics: frames that can be told apart, from scenes of any size."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from derod.pushing.frames import Ending, Event, Frame, Observer, Outcome
from derod.pushing.rows import ROW
from derod.record import Run
from derod.scene import Scene, parse_scene

SCENE_TEXT = """
[rod]
length = 10
bending = 1
twisting = 0.9
[drop]
capillary_force = 20
wall_strength = 2e-4
wall_softness = 0.1
[push]
start = "0.01 pi"
stop = "0.4 pi"
at = ["0.1 pi", "0.25 pi"]
[mesh]
edges = 24
"""


def small_scene(**changes: object) -> Scene:
    """The paper's rod with 24 edges; ``push__stop=...`` changes push.stop, and so on."""
    scene = parse_scene(SCENE_TEXT)
    return scene.replace({key.replace("__", "."): value for key, value in changes.items()})


def make_frame(i: int, edges: int, end_shortening: float | None = None) -> Frame:
    """Frame ``i``: every number in it is a function of ``i`` and of its place."""
    row = np.zeros((), ROW)
    row["increment"] = i
    row["end_shortening"] = 0.01 * (i + 1) if end_shortening is None else end_shortening
    row["end_tension"] = 10.0 + np.sin(i)
    row["residual"] = 1e-10 * (1 + i % 7)
    row["converged"] = True
    row["landing"] = i % 10 == 9
    nodes = np.arange(edges + 1, dtype=float)
    return Frame(
        row=row[()],
        positions=i + np.outer(nodes, [1.0, 0.01, 0.0001]),
        arc_length=i + nodes / edges,
        drop_center=np.array([i, i + 0.25, -i]),
        edge_tension=-i - nodes[:-1],
    )


def is_frame(run: Run, i: int) -> bool:
    """Whether ``run`` gives back frame ``i`` as ``make_frame`` made it."""
    made = make_frame(i, run.scene.mesh.edges, run.table[i]["end_shortening"])
    read = run.frame_at(i)
    return (
        made.row == read.row
        and np.array_equal(made.positions, read.positions)
        and np.array_equal(made.arc_length, read.arc_length)
        and np.array_equal(made.drop_center, read.drop_center)
        and np.array_equal(made.edge_tension, read.edge_tension)
    )


def make_event(i: int) -> Event:
    return Event(
        i, "instability", 0.01 * (i + 1), 2.0, 1.0, f"before increment {i}: é", 0.01 * (i + 1)
    )


def drive(scene: Scene, observers: Sequence[Observer], resume: Run | None = None) -> Ending:
    """Stands in for ``derod.pushing.driver.drive``: 0.01 pi an increment, an event before every fifth."""
    first = 0 if resume is None else len(resume)
    steps = round((scene.push.stop[-1] - scene.push.start) / (0.01 * np.pi)) + 1
    for observer in observers:
        observer.start(scene, first)
    for i in range(first, steps):
        if i % 5 == 4:
            for observer in observers:
                observer.event(make_event(i))
        end_shortening = scene.push.start + 0.01 * np.pi * i
        for observer in observers:
            observer.frame(make_frame(i, scene.mesh.edges, end_shortening))
    ending = Ending(Outcome.COMPLETED, "reached 0.4 pi", scene.push.stop[-1])
    for observer in observers:
        observer.finish(ending)
    return ending
