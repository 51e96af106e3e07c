"""Where the drawing meets rerun: static things, columns, events."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
import rerun as rr

from derod.pushing.frames import Ending, Event
from derod.record import profiles as fields
from derod.record.geometry import sphere, tube_triangles
from derod.scene import Scene
from derod.views.stream.blueprint import run_blueprint
from derod.views.stream.drawing import (
    FORCE,
    PLOT_CAPILLARY,
    PLOT_RESIDUAL,
    PUSH,
    RADIUS,
    SIDES,
    Column,
)
from derod.views.stream.legend import EDGE, draw_legend, wall_edge

WATER = (120, 175, 235, 46)
BRASS = (196, 160, 92, 255)
RED, PINK, ORANGE, WHITE = (213, 94, 0), (204, 121, 167), (230, 159, 0), (245, 245, 245)

SERIES = {
    "plots/tension": ("t, K0/D²", (86, 180, 233)),
    "plots/energy/hat": ("Ê, K0/D", (150, 152, 160)),
    "plots/energy/bend": ("bend", (230, 159, 0)),
    "plots/energy/twist": ("twist", (0, 158, 115)),
    "plots/energy/wall": ("wall", (204, 121, 167)),
    PLOT_CAPILLARY: ("capillary + fγ(δ+1)", (86, 180, 233)),
    "plots/wetted_length": ("wetted length, D", (86, 180, 233)),
    "plots/unstable_modes": ("unstable modes", (213, 94, 0)),
    PLOT_RESIDUAL: ("log10 residual, K0/D²", (0, 158, 115)),
    "plots/relaxation": ("log10 residual, K0/D²", (0, 158, 115)),
}
"""Names and colours of the time series."""

TINTS = {"instability": ORANGE, "snap": ORANGE, "coarse": RED}
"""Colours of events in the log; a push that loses its stability is no warning, a coarse mesh is."""


class Stage:
    """Draws one push into a recording."""

    def __init__(self, recording: Any, scene: Scene, color: str, *, live: bool) -> None:
        self.recording = recording
        self.scene = scene
        self.nodes = 0
        recording.send_blueprint(run_blueprint(live=live))
        scale = fields.coloring(color, scene)
        self._static("world", rr.ViewCoordinates.RIGHT_HAND_Y_UP)
        if scene.drop is not None:
            self._static("world/drop/surface", drop_mesh())
            self._static("world/drop/edge", wall_edge(scene.drop.wall_softness))
        block = rr.Boxes3D(
            centers=[[0, 0, 0]], half_sizes=[[0.05, 0.05, 0.02]], colors=[BRASS], fill_mode="solid"
        )
        self._static("world/clamps/start", block)
        self._static("world/clamps/end", block)
        style = rr.LineStrips3D.from_fields
        self._static("world/rod/stripe", style(radii=0.12 * RADIUS, colors=[WHITE]))
        self._static("world/rod/frame", _arrows(WHITE, 0.0015))
        self._static("world/menisci/points", rr.Points3D.from_fields(colors=[RED], radii=0.03))
        self._static("world/menisci/forces", _arrows(RED, 0.009))
        self._static("world/wall", _arrows(PINK, 0.0025))
        keys = {"menisci": RED, "wall": PINK, "director": WHITE, "edge": EDGE}
        draw_legend(recording, scale, keys, scene.drop is not None)
        for entity, (name, tint) in SERIES.items():
            self._static(entity, rr.SeriesLines(names=name, colors=[tint], widths=1.8))
        self._static(
            "about", rr.TextDocument(about(scene, scale.meaning), media_type="text/markdown")
        )

    def _static(self, entity: str, what: Any) -> None:
        self.recording.log(entity, what, static=True)

    def send(self, columns: Sequence[Column], rows: np.ndarray) -> None:
        """Show frames (their rows (T,)) at their increment and end-shortening."""
        self.send_at(
            columns,
            [
                rr.TimeColumn("increment", sequence=rows["increment"]),
                rr.TimeColumn("end_shortening", duration=rows["end_shortening"]),
            ],
        )

    def send_at(self, columns: Sequence[Column], indexes: Sequence[Any]) -> None:
        """Show columns at any times."""
        for column in columns:
            if column.entity == "world/rod/tube":
                self._lay_triangles(len(column.fields["vertex_positions"][0]) // SIDES)
            send_column(self.recording, column, indexes)

    def _lay_triangles(self, rings: int) -> None:
        if rings != self.nodes:
            self.nodes = rings
            triangles = tube_triangles(rings, SIDES)
            self._static("world/rod/tube", rr.Mesh3D.from_fields(triangle_indices=triangles))

    def events(self, events: Sequence[Event]) -> None:
        """Write events into the log, at the frame that follows them."""
        if not events:
            return
        self.recording.send_columns(
            "events",
            indexes=[
                rr.TimeColumn("increment", sequence=[event.increment for event in events]),
                rr.TimeColumn(
                    "end_shortening", duration=[event.end_shortening for event in events]
                ),
            ],
            columns=rr.TextLog.columns(
                text=[event_text(event) for event in events],
                level=["WARN" if event.kind == "coarse" else "INFO" for event in events],
                color=[TINTS.get(event.kind, WHITE) for event in events],
            ),
        )

    def ending(self, ending: Ending, increment: int) -> None:
        """Write how it ended into the log."""
        shown = 0.0 if math.isnan(ending.end_shortening) else ending.end_shortening
        self.recording.send_columns(
            "events",
            indexes=[
                rr.TimeColumn("increment", sequence=[increment]),
                rr.TimeColumn("end_shortening", duration=[shown]),
            ],
            columns=rr.TextLog.columns(
                text=[f"{ending.outcome.replace('_', ' ')}: {ending.message}"],
                level=["INFO" if ending.outcome == "completed" else "ERROR"],
                color=[WHITE if ending.outcome == "completed" else RED],
            ),
        )


def drop_mesh() -> Any:
    """The drop, translucent, about its centre."""
    vertices, triangles = sphere(0.5)
    return rr.Mesh3D(
        vertex_positions=vertices,
        vertex_normals=2 * vertices,
        triangle_indices=triangles,
        albedo_factor=WATER,
    )


def _arrows(color: tuple[int, int, int], radius: float) -> Any:
    return rr.Arrows3D.from_fields(colors=[color], radii=radius)


def send_column(recording: Any, column: Column, indexes: Sequence[Any]) -> None:
    """Send one entity's column: one item a time, each of any length."""
    lengths = [len(item) for item in next(iter(column.fields.values()))]
    flat: dict[str, Any] = {}
    for name, items in column.fields.items():
        if name == "strips":
            flat[name] = [strip for item in items for strip in item]
        else:
            flat[name] = np.concatenate(list(items))
    if sum(lengths) == 0:
        return
    columns = getattr(rr, column.archetype).columns(**flat)
    recording.send_columns(column.entity, indexes=indexes, columns=columns.partition(lengths))


def event_text(event: Event) -> str:
    """An event in a line."""
    text = f"{event.kind} at {event.end_shortening / math.pi:.4f} pi"
    if not (math.isnan(event.energy_before) or math.isnan(event.energy_after)):
        text += f", E_hat {event.energy_before:.6g} -> {event.energy_after:.6g}"
    return f"{text}: {event.message}" if event.message else text


def about(scene: Scene, color: str) -> str:
    """What one looks at, in Markdown."""
    rod, drop = scene.rod, scene.drop
    water = (
        "no drop"
        if drop is None
        else f"**fγ** = {drop.capillary_force:g}, **v0** = {drop.wall_strength:g}, "
        f"**ρ** = {drop.wall_softness:g}"
    )
    return (
        f"**l** = {rod.length:g}, **k3** = {rod.twisting:g}, {water}, {scene.mesh.edges} edges\n\n"
        f"The rod is coloured by {color}. The white line on it is the material d1: it winds where "
        "the rod is twisted. Orange: menisci and their pull (1 K0/D² = "
        f"{FORCE:g} D). Pink: the wall's push on the rod (1 K0/D³ = {PUSH:g} D).\n\n"
        "Thin circles: where the soft wall is singular; the rod leaves the drop a little.\n\n"
        "Timeline *end_shortening*: δ in D, written as seconds: rerun has no other real-valued one."
    )
