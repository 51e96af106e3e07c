"""From frames of a run to what is drawn of them: columns of plain arrays, one item a frame.

The live stream draws one frame at a time and the replay all of them; both come through here, so
that they look the same.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from derod.pushing.frames import Frame
from derod.record import profiles as fields
from derod.record.geometry import MaterialFrame, material_frame, point_at, tube
from derod.record.sections import section_frame
from derod.scene import Scene

RADIUS = 0.017  # D, of the tube; the rod of the model is a curve
SIDES = 10
MOST_RINGS = 1200
FORCE = 0.015  # D of arrow for K0/D^2
PUSH = 0.004  # D of arrow for K0/D^3
STATIONS = 60  # where the material frame is shown
SPOKE = 0.055  # D, its length

PLOTS = {
    "plots/tension": "end_tension",
    "plots/energy/hat": "energy_hat",
    "plots/energy/bend": "energy_bend",
    "plots/energy/twist": "energy_twist",
    "plots/energy/wall": "energy_wall",
    "plots/wetted_length": "wetted_length",
    "plots/unstable_modes": "unstable_modes",
}
"""Time series and the fields of a row that they show; two more are computed."""
PLOT_CAPILLARY = "plots/energy/capillary"  # energy_capillary + f_gamma (delta + 1)
PLOT_RESIDUAL = "plots/residual"  # its decimal logarithm


@dataclass(frozen=True, slots=True)
class Column:
    """What one entity shows: ``fields`` of a rerun archetype, one array a frame."""

    entity: str
    archetype: str
    fields: dict[str, Any]  # of sequences


@dataclass(frozen=True, slots=True)
class Batch:
    """Some frames of one run, stacked."""

    rows: np.ndarray  # (T,) of frames.ROW
    positions: np.ndarray  # (T, N+1, 3)
    arc_length: np.ndarray  # (T, N+1)
    drop_center: np.ndarray  # (T, 3)
    edge_tension: np.ndarray  # (T, N)
    edge_frame: np.ndarray | None = None  # (T, N, 7) of a section with directions

    @classmethod
    def of(cls, frames: Sequence[Frame]) -> Batch:
        """Stack frames."""
        return cls(
            np.array([frame.row for frame in frames]),
            np.stack([frame.positions for frame in frames]),
            np.stack([frame.arc_length for frame in frames]),
            np.stack([frame.drop_center for frame in frames]),
            np.stack([frame.edge_tension for frame in frames]),
            edge_frames(frames),
        )


def edge_frames(frames: Sequence[Frame]) -> np.ndarray | None:
    """Stack the frames of the edges, where there are any."""
    made = [frame.edge_frame for frame in frames if frame.edge_frame is not None]
    return np.stack(made) if made else None


def shown_nodes(nodes: int) -> np.ndarray:
    """Which nodes get a ring of the tube: all, but for very fine rods."""
    every = -(-nodes // MOST_RINGS)
    return np.unique(np.append(np.arange(0, nodes, every), nodes - 1))


def draw(batch: Batch, scene: Scene, color: str) -> list[Column]:
    """Everything that is drawn of the frames, and their time series."""
    return [*draw_shapes(batch, scene, color), *draw_plots(batch.rows, scene)]


def draw_shapes(batch: Batch, scene: Scene, color: str) -> list[Column]:
    """The rod, its frame, the drop, the clamps, the menisci and the wall's push."""
    rows, x, s = batch.rows, batch.positions, batch.arc_length
    center = batch.drop_center
    if scene.drop is None:  # the eye is on the middle then
        center = 0.5 * (x[:, 0] + x[:, -1])
    twist = (rows["end_rotation"] - rows["holonomy"]) / scene.rod.length
    if batch.edge_frame is None:
        frame = material_frame(x, s, twist)
    else:
        each = map(section_frame, x, s, batch.edge_frame, [scene] * len(x))
        frame = MaterialFrame(*map(np.stack, zip(*each, strict=True)))
    inside = fields.wetted(s, rows["meniscus_a"], rows["meniscus_b"])
    push = np.where(inside, fields.wall_push(x, batch.drop_center, scene), 0.0)
    keep = shown_nodes(x.shape[1])
    frame = type(frame)(*(d[:, keep] for d in frame))
    vertices, normals = tube(x[:, keep], frame, RADIUS, SIDES)
    colors = fields.paint(_field(color, batch, twist, push), fields.coloring(color, scene))
    spokes = np.unique(np.linspace(0, keep.size - 1, STATIONS).round().astype(int))
    inward = center[:, None, :] - x
    inward /= np.maximum(np.linalg.norm(inward, axis=-1, keepdims=True), 1e-9)
    shown = [
        Column(
            "world/rod/tube",
            "Mesh3D",
            {
                "vertex_positions": list(vertices.astype(np.float32)),
                "vertex_normals": list(normals.astype(np.float32)),
                "vertex_colors": list(np.repeat(colors[:, keep], SIDES, axis=1)),
            },
        ),
        Column(
            "world/rod/stripe",
            "LineStrips3D",
            {"strips": [[line] for line in (x[:, keep] + 1.06 * RADIUS * frame.d1).astype("f4")]},
        ),
        Column(
            "world/rod/frame",
            "Arrows3D",
            {
                "origins": list(x[:, keep[spokes]].astype(np.float32)),
                "vectors": list((SPOKE * frame.d1[:, spokes]).astype(np.float32)),
            },
        ),
        Column("world/drop", "Transform3D", {"translation": center[:, None]}),
        Column("world/clamps/end", "Transform3D", {"translation": x[:, -1:]}),
    ]
    if scene.drop is None:
        return shown
    menisci, forces = _menisci(batch)
    return [
        *shown,
        Column("world/menisci/points", "Points3D", {"positions": menisci}),
        Column("world/menisci/forces", "Arrows3D", {"origins": menisci, "vectors": forces}),
        Column(
            "world/wall",
            "Arrows3D",
            {
                "origins": [x[i][inside[i]] for i in range(len(x))],
                "vectors": [
                    PUSH * (push[i, :, None] * inward[i])[inside[i]] for i in range(len(x))
                ],
            },
        ),
    ]


def _field(name: str, batch: Batch, twist: np.ndarray, push: np.ndarray) -> np.ndarray:
    if name == "curvature":
        return fields.curvature(batch.positions, batch.arc_length)
    if name == "tension":
        return fields.node_tension(batch.edge_tension)
    if name == "wall":
        return push
    return np.broadcast_to(twist[:, None], batch.arc_length.shape)


def _menisci(batch: Batch) -> tuple[np.ndarray, np.ndarray]:
    """Points A and B and the forces of the drop on the rod there, as arrows, each (T, 2, 3)."""
    points = np.array(
        [
            [point_at(x, s, row["meniscus_a"]), point_at(x, s, row["meniscus_b"])]
            for x, s, row in zip(batch.positions, batch.arc_length, batch.rows, strict=True)
        ]
    )
    sizes = np.stack([batch.rows["force_a"], batch.rows["force_b"]], axis=1)[..., None]
    inward = batch.drop_center[:, None] - points
    inward /= np.maximum(np.linalg.norm(inward, axis=-1, keepdims=True), 1e-9)
    return points, FORCE * sizes * inward


def draw_plots(rows: np.ndarray, scene: Scene) -> list[Column]:
    """The time series of the rows (T,)."""
    f_gamma = 0.0 if scene.drop is None else scene.drop.capillary_force
    surface = rows["energy_capillary"] + f_gamma * (rows["end_shortening"] + 1)
    residual = np.log10(np.maximum(rows["residual"], 1e-300))
    values = {entity: rows[name].astype(float) for entity, name in PLOTS.items()}
    values |= {PLOT_CAPILLARY: surface, PLOT_RESIDUAL: residual}
    return [
        Column(entity, "Scalars", {"scalars": list(series[:, None])})
        for entity, series in values.items()
    ]
