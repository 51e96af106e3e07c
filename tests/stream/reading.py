"""An .rrd file read back: which entities have which rows on which timelines."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any


@dataclass
class Entity:
    rows: int = 0
    times: dict[str, list[Any]] = field(default_factory=dict)
    arrays: dict[str, list[Any]] = field(default_factory=dict)
    static: set[str] = field(default_factory=set)

    def values(self, name: str) -> list[Any]:
        return [value for array in self.arrays[name] for value in array.to_pylist()]


@dataclass
class Contents:
    entities: dict[str, Entity]
    blueprints: int

    def __getitem__(self, name: str) -> Entity:
        return self.entities["/" + name]

    def __contains__(self, name: str) -> bool:
        return "/" + name in self.entities


def read_rrd(path: Path) -> Contents:
    import rerun as rr

    reader = rr.chunk.RrdReader(str(path))
    assert len(reader.recordings()) == 1
    entities: dict[str, Entity] = {}
    for chunk in reader.stream().to_chunks():
        entity = entities.setdefault(str(chunk.entity_path), Entity())
        batch = chunk.to_record_batch()
        names = [name for name in batch.schema.names if name != "rerun.controls.RowId"]
        if chunk.is_static:
            entity.static.update(names)
            continue
        entity.rows += chunk.num_rows
        for name in names:
            if name in chunk.timeline_names:
                entity.times.setdefault(name, []).extend(plain(batch.column(name)))
            else:
                entity.arrays.setdefault(name, []).append(batch.column(name))
    return Contents(entities, len(reader.blueprints()))


def plain(column: Any) -> list[Any]:
    """Values of a column; durations as nanoseconds."""
    import pyarrow as pa

    if pa.types.is_duration(column.type):
        column = column.cast(pa.int64())
    return column.to_pylist()


def seconds(durations: list[int]) -> list[float]:
    """Times of a duration timeline, in seconds."""
    return [d / 1e9 for d in durations]
