"""A run as a time series for ParaView: NAME.pvd, and beside it the folder NAME with a .vtp file a frame.

The time is the end-shortening (D), or the increment where the push does not only go forward. Part 0 is the
rod, a polyline with its fields at the nodes; part 1 the drop, a sphere.
"""

from __future__ import annotations

import shutil
import tempfile
from pathlib import Path
from typing import Any

import numpy as np

from derod.exits import UsageError
from derod.record.geometry import sphere
from derod.record.profiles import curvature, node_tension, wetted
from derod.scene.axis import axes_of, axis_of
from derod.views.export.output import write_file
from derod.views.export.vtk import Field, collection, poly_data

DROP_RADIUS = 0.5  # D
SCALARS = {
    "increment": "",
    "end_shortening": "D",
    "end_tension": "K0/D^2",
    "energy_hat": "K0/D",
    "wetted_length": "D",
    "unstable_modes": "",
}
"""Columns of the run's table that every frame carries as field data, and their units."""


def write_series(run: Any, path: Path, force: bool) -> list[Path]:
    """Write the .pvd file ``path`` and its folder; the .pvd last, so that it never names half a series.

    Returns the files. Raises UsageError, also where the folder is there and ``force`` is not given.
    """
    folder = path.with_suffix("")
    if folder.exists() and not force:
        raise UsageError(
            f"-o = {path}: its folder {folder} exists; allowed: another name, or --force to replace it"
        )
    if folder.exists() and not _is_ours(folder):
        raise UsageError(
            f"-o = {path}: {folder} holds other things than .vtp files; allowed: another name"
        )
    try:
        with tempfile.TemporaryDirectory(dir=path.parent, prefix=f".{folder.name}-") as name:
            made = Path(name) / "series"
            made.mkdir()
            items = _write_frames(run, made, folder.name)
            if folder.exists():
                shutil.rmtree(folder)
            made.rename(folder)
    except OSError as error:
        raise UsageError(f"-o = {path}: cannot be written: {error.strerror}") from None
    write_file(path, collection(items), force)
    return [path, *(path.parent / item[3] for item in items)]


def _is_ours(folder: Path) -> bool:
    return folder.is_dir() and all(part.suffix == ".vtp" for part in folder.iterdir())


def _write_frames(run: Any, made: Path, name: str) -> list[tuple[float, int, str, str]]:
    items = []
    for i, time in enumerate(times(run)):
        parts = [("rod", rod_frame(run, i))]
        if run.scene.drop is not None:
            parts.append(("drop", drop_frame(run, i)))
        for part, (what, data) in enumerate(parts):
            file = f"{what}_{i:05d}.vtp"
            (made / file).write_bytes(data)
            items.append((time, part, what, f"{name}/{file}"))
    return items


def times(run: Any) -> list[float]:
    """The time of every frame: what drives the push (end-shortening, D) if it grows, else increments."""
    values = run.table[axis_of(run.scene).column]
    if len(axes_of(run.scene)) == 1 and np.all(np.diff(values) > 0):
        return [float(x) for x in values]
    return [float(i) for i in range(len(values))]


def rod_frame(run: Any, i: int) -> bytes:
    """Increment ``i``: nodes (N+1, 3) as one polyline, with fields at the nodes."""
    row = run.table[i]
    x, s = run.positions(i), run.arc_length(i)
    frame = run.directors(i)
    point_data = {
        "arc_length": Field(s, "D"),
        "curvature": Field(curvature(x, s), "1/D"),
        "tension": Field(node_tension(run.edge_tension(i)), "K0/D^2"),
        "tangent": Field(frame.d3),
        "director_1": Field(frame.d1),
    }
    if run.scene.drop is not None:
        inside = wetted(s, row["meniscus_a"], row["meniscus_b"])
        point_data["wetted"] = Field(inside.astype("u1"))
    fields = {name: Field(np.array([row[name]]), unit) for name, unit in SCALARS.items()}
    return poly_data(x, [np.arange(len(x))], "Lines", point_data, fields)


def drop_frame(run: Any, i: int) -> bytes:
    """The drop at increment ``i``: a sphere of diameter D."""
    vertices, triangles = sphere(DROP_RADIUS, rings=24, sides=48)
    points = (vertices + run.drop_center(i)).astype("f4")
    return poly_data(points, list(triangles), "Polys")
