"""What a sweep is: a scene, what varies in it, and which rows of each push are kept.

A sweep file::

    scene = "paper-text"          # a shipped scene, or a file beside this one

    [set]                         # changes for all points
    "mesh.edges" = 100
    "push.stop" = "2 pi"

    [keys]                        # what varies (derod.sweeps.spreads)
    "drop.capillary_force" = {from = 10, to = 40, count = 40}
    "rod.length" = {from = 8, to = 14, count = 40}

    keys = "uncertain"            # instead, before the first table: all values of [material] with +-

    [design]                      # derod.sweeps.sampling; a grid where left out
    kind = "grid"                 # grid, list, latin-hypercube, sobol, differences
    points = 128                  # of latin-hypercube and sobol
    seed = 0

    [table]
    rows = "last"                 # of each push: last, landings (push.at), all
"""

from __future__ import annotations

import json
import os
import tomllib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from derod.errors import SceneError
from derod.scene import Scene, parse_scene
from derod.scene.directors import check_pushable
from derod.scene.plain import plain
from derod.scenes import is_shipped, read_scene
from derod.sweeps.sampling import GRID, SAMPLED, Point, check_design, points_of
from derod.sweeps.spreads import Spread, read_spread, rule_of
from derod.sweeps.uncertainty import uncertain_keys

ROWS = ("last", "landings", "all")
UNCERTAIN = "uncertain"
"""Instead of keys: all values of [material] that have an uncertainty."""
TABLES = ("scene", "set", "keys", "design", "table")
MOST_BYTES = 2**24
"""Of a sweep file."""


@dataclass(frozen=True, slots=True)
class Plan:
    """A sweep, checked: ``plan.points()`` are what is to be pushed."""

    scene: Scene
    """What does not vary."""
    spreads: tuple[Spread, ...]
    design: str
    count: int
    seed: int
    rows: str

    @property
    def keys(self) -> tuple[str, ...]:
        """The keys that vary."""
        return tuple(spread.key for spread in self.spreads)

    def points(self) -> Iterator[Point]:
        """The values of every point, in order."""
        return points_of(self.design, self.spreads, self.count, self.seed)

    def changes(self, point: Point) -> dict[str, Any]:
        """What a point changes in the scene."""
        return dict(zip(self.keys, point, strict=True))

    @property
    def text(self) -> str:
        """The plan as text, the same for the same plan; ``plan_of_text`` gives it back."""
        return json.dumps(
            {
                "scene": self.scene.text,
                "keys": {spread.key: spread.written for spread in self.spreads},
                "design": self.design,
                "count": self.count,
                "seed": self.seed,
                "rows": self.rows,
            },
            indent=1,
        )


def make_plan(
    scene: Scene,
    keys: Mapping[str, Any] | str,
    *,
    design: str = GRID,
    points: object = None,
    seed: object = 0,
    rows: object = "last",
    file: str | None = None,
) -> Plan:
    """A checked plan. ``keys``: what varies, as ``derod.sweeps.spreads`` reads it. Raises SceneError."""
    if keys == UNCERTAIN:
        keys = uncertain_keys(scene, file)
    if not isinstance(keys, Mapping):
        raise SceneError("is no table of keys", file=file, key="keys", value=keys)
    spreads = tuple(read_spread(str(key), written, file) for key, written in keys.items())
    count = check_design(design, spreads, points, file)
    if isinstance(seed, bool) or not isinstance(seed, int) or not 0 <= seed < 2**63:
        raise SceneError("is no seed", file=file, key="design.seed", value=seed,
                         allowed="an integer from 0 to 2^63 - 1")  # fmt: skip
    if rows not in ROWS:
        raise SceneError("are no rows of a push", file=file, key="table.rows", value=rows,
                         allowed=", ".join(ROWS))  # fmt: skip
    if rows == "landings" and not (scene.push.at or any(step.at for step in scene.steps)):
        raise SceneError("asks for landings, and the scene has none", file=file, key="table.rows",
                         value=rows, allowed="push.at in the scene, or under [set]")  # fmt: skip
    check_pushable(scene)
    return Plan(scene, spreads, design, count, seed, str(rows))


def read_plan(path: str | os.PathLike[str]) -> Plan:
    """The plan of a sweep file. Raises SceneError, which names file, key, value and what is allowed."""
    name = os.fsdecode(os.fspath(path))
    try:
        with Path(name).open("rb") as file:
            data = file.read(MOST_BYTES + 1)
        if len(data) > MOST_BYTES:
            raise ValueError(f"it is longer than {MOST_BYTES} bytes")
        tables = tomllib.loads(data.decode("utf-8-sig"))
    except OSError as error:
        raise SceneError(f"cannot be read: {error.strerror or error}", file=name) from error
    except (ValueError, RecursionError) as error:
        raise SceneError(f"cannot be read as a sweep: {error}", file=name) from error
    for key, value in tables.items():
        if key not in TABLES:
            raise SceneError("is unknown", file=name, key=key, allowed=", ".join(TABLES))
        plain_keys = key == "keys" and value == UNCERTAIN
        if key != "scene" and not plain_keys and not isinstance(value, Mapping):
            raise SceneError("is not a table", file=name, key=key, value=value, allowed=f"[{key}]")
    for key in ("scene", "keys"):
        if key not in tables:
            raise SceneError("is missing", file=name, key=key)
    design = _only(tables.get("design", {}), "design", ("kind", "points", "seed"), name)
    table = _only(tables.get("table", {}), "table", ("rows",), name)
    scene = _base(tables["scene"], Path(name).parent, name)
    changes = {key: _several(key, value, name) for key, value in tables.get("set", {}).items()}
    return make_plan(
        scene.replace(changes) if changes else scene,
        tables["keys"],
        design=design.get("kind", GRID),
        points=design.get("points"),
        seed=design.get("seed", 0),
        rows=table.get("rows", "last"),
        file=name,
    )


def plan_of_text(text: str, file: str) -> Plan:
    """The plan that ``Plan.text`` wrote. Raises SceneError."""
    try:
        data = json.loads(text)
        scene, keys, design = data["scene"], data["keys"], data["design"]
        count, seed, rows = data["count"], data["seed"], data["rows"]
    except (KeyError, TypeError, ValueError) as error:
        raise SceneError("does not say what was swept", file=file) from error
    points = count if design in SAMPLED else None
    return make_plan(parse_scene(scene, path=file), keys, design=design, points=points, seed=seed,
                     rows=rows, file=file)  # fmt: skip


def _base(scene: object, folder: Path, file: str) -> Scene:
    """The scene that a sweep file names: shipped, or a file beside it."""
    if not isinstance(scene, str):
        raise SceneError("is no name", file=file, key="scene", value=scene,
                         allowed="a shipped scene's name or a file beside this one")  # fmt: skip
    return read_scene(scene if is_shipped(scene) else folder / scene)


def _only(table: Mapping[str, Any], name: str, keys: Sequence[str], file: str) -> Mapping[str, Any]:
    for key, value in table.items():
        if key not in keys:
            raise SceneError("is unknown", file=file, key=f"{name}.{key}", value=value,
                             allowed=", ".join(keys))  # fmt: skip
    return table


def _several(key: str, value: Any, file: str) -> Any:
    """A value of [set]; a range with a count is a list, as landings are wanted."""
    if not isinstance(value, Mapping):
        return plain(value)
    table, _, name = key.partition(".")
    if (table, name) not in (("push", "at"), ("push", "stop")):
        rule_of(key, file)
        raise SceneError("is a range", file=file, key=key, value=dict(value),
                         allowed="one value; what varies belongs to [keys]")  # fmt: skip
    return [plain(x) for x in read_spread("push.start", value, file).values]
