"""Scenes built in code, with the checks and the messages of scene files."""

from __future__ import annotations

import os
from collections.abc import Mapping
from typing import Any

from derod.scene.plain import plain, plain_tables
from derod.scene.reading import build_scene
from derod.scene.tables import Scene as CheckedScene


def scene(
    base: CheckedScene | str | os.PathLike[str] | None = None,
    changes: Mapping[str, Any] | None = None,
    /,
    **tables: Mapping[str, Any] | None,
) -> CheckedScene:
    """A checked scene, from tables as a file has them, or from another one with something changed.

    ::

        derod.Scene(
            rod={"length": 10, "bending": 1, "twisting": 0.9},
            drop={"capillary_force": 20, "wall_strength": 2e-4, "wall_softness": 0.1},
            push={"start": "0.001 pi", "stop": "1 pi"},
        )
        derod.Scene("quick", {"mesh.edges": 200, "push.stop": "1 pi"})
        derod.Scene("quick", mesh={"edges": 200})

    ``base`` is a scene, a file, or the name of a shipped one. Keys of ``tables`` take the place of the
    base's, all others stay; ``changes`` names keys with dots and is made last. A table that is None is left
    out. Raises SceneError, as a file with these values would.
    """
    data: dict[str, Any] = {} if base is None else dict(plain_tables(_read(base)))
    for name, table in tables.items():
        if table is None:
            data.pop(name, None)
            continue
        new = plain(table)
        before = data.get(name, {})
        data[name] = {**before, **new} if isinstance(new, dict) else new
    path = None if base is None else _read(base).path
    if changes is None:
        return build_scene(data, path)
    if base is None and not tables:
        return build_scene(_nested(changes), path)
    return build_scene(data, path).replace(changes)


def _read(base: CheckedScene | str | os.PathLike[str]) -> CheckedScene:
    if isinstance(base, CheckedScene):
        return base
    from derod.scenes import read_scene

    return read_scene(base)


def _nested(changes: Mapping[str, Any]) -> dict[str, Any]:
    """Keys with dots as tables of tables."""
    data: dict[str, Any] = {}
    for dotted, value in changes.items():
        table, dot, name = str(dotted).partition(".")
        if dot:
            data.setdefault(table, {})[name] = plain(value)
        else:
            data[table] = plain(value)
    return data


class _Built(type):
    def __call__(cls, *args: Any, **tables: Any) -> CheckedScene:
        return scene(*args, **tables)

    def __instancecheck__(cls, thing: object) -> bool:
        return isinstance(thing, CheckedScene)


class Scene(metaclass=_Built):
    """Makes checked scenes; all scenes are instances of it."""

    __doc__ = scene.__doc__
