"""An .rrd file read back: which entities have which rows on which timelines."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any


@dataclass
class Entity:
    rows: int = 0
    times: dict[str, list[Any]] = field(default_factory=dict)
    values: dict[str, list[Any]] = field(default_factory=dict)
    static: dict[str, Any] = field(default_factory=dict)


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
        columns = {name: batch.column(name).to_pylist() for name in batch.schema.names}
        columns.pop("rerun.controls.RowId", None)
        if chunk.is_static:
            entity.static.update({name: values[-1] for name, values in columns.items()})
            continue
        entity.rows += chunk.num_rows
        for name, values in columns.items():
            kind = entity.times if name in chunk.timeline_names else entity.values
            kind.setdefault(name, []).extend(values)
    return Contents(entities, len(reader.blueprints()))


def seconds(durations: list[Any]) -> list[float]:
    """Times of a duration timeline, in seconds."""
    return [d.total_seconds() if hasattr(d, "total_seconds") else d / 1e9 for d in durations]
