"""From the text of a scene file to a checked Scene."""

from __future__ import annotations

import difflib
import os
import tomllib
from collections.abc import Mapping
from functools import cache
from pathlib import Path
from typing import Any

import msgspec.structs

from derod.errors import SceneError
from derod.scene.controls import HELD, held_value
from derod.scene.material import MATERIAL_KEYS, with_groups
from derod.scene.plain import plain, plain_tables
from derod.scene.rules import KEYS, Key
from derod.scene.tables import (
    Clamps,
    Drop,
    Material,
    Mesh,
    Model,
    Noise,
    Push,
    Relax,
    Rod,
    Scene,
    Step,
    Table,
)
from derod.scene.together import check_together

MOST_BYTES = 2**18
"""Of a scene file."""
BYTE_ORDER_MARK = "\ufeff"
TABLES: dict[str, type[Table]] = {
    "material": Material,
    "rod": Rod,
    "drop": Drop,
    "clamps": Clamps,
    "push": Push,
    "steps": Step,
    "mesh": Mesh,
    "relax": Relax,
    "noise": Noise,
    "model": Model,
}
ALL_KEYS = {"material": MATERIAL_KEYS, **KEYS}


def load_scene(path: str | os.PathLike[str]) -> Scene:
    """The scene of a TOML file; raises SceneError if it cannot be read or is not allowed."""
    try:
        name = os.fsdecode(os.fspath(path))
    except TypeError as error:
        raise SceneError("is no name of a file", value=path) from error
    try:
        with Path(name).open("rb") as file:
            data = file.read(MOST_BYTES + 1)
        if len(data) > MOST_BYTES:
            raise SceneError(
                f"cannot be read: it is too long; allowed: {MOST_BYTES} bytes", file=name
            )
        text = data.decode("utf-8")
    except OSError as error:
        raise SceneError(f"cannot be read: {error.strerror or error}", file=name) from error
    except ValueError as error:  # not UTF-8, or a null byte in the name
        raise SceneError(f"cannot be read: {error}", file=name) from error
    return parse_scene(text, path=name)


def parse_scene(text: str, path: str | os.PathLike[str] | None = None) -> Scene:
    """The scene written in ``text``; ``path`` is only named in errors. Raises SceneError."""
    name = None if path is None else os.fspath(path)
    if not isinstance(text, str):
        raise SceneError("is no text", file=name, value=text)
    try:
        data = tomllib.loads(text.removeprefix(BYTE_ORDER_MARK))
    except (ValueError, RecursionError) as error:
        reason = str(error) or type(error).__name__
        raise SceneError(f"is not valid TOML: {reason}", file=name) from error
    return build_scene(data, name)


def build_scene(data: Mapping[str, Any], path: str | None = None) -> Scene:
    """The scene of nested tables of plain values, as TOML gives them. Raises SceneError."""
    if not isinstance(data, Mapping):
        raise SceneError("is no table of tables", file=path, value=data)
    for name, value in data.items():
        if name not in TABLES:
            raise _unknown_table(name, path)
        if name != "steps" and not isinstance(value, Mapping):
            raise SceneError(
                "is not a table", file=path, key=name, value=value, allowed=f"[{name}]"
            )
    model = _read_table("model", data.get("model", {}), path)
    dry = isinstance(model, Model) and not model.drop
    if dry and "drop" in data:
        raise SceneError("is there although model.drop = false", file=path, key="drop")
    material: Material | None = None
    if "material" in data:
        if dry:
            raise SceneError("needs a drop: D is its unit", file=path, key="material",
                             allowed="model.drop = true")  # fmt: skip
        experiment = _read_table("material", data["material"], path)
        assert isinstance(experiment, Material)
        material = experiment
        data = with_groups(data, material, path)
    tables: dict[str, Any] = {
        name: None if dry and name == "drop" else _read_table(name, data.get(name, {}), path)
        for name in KEYS
        if name != "steps"
    }
    steps = data.get("steps", ())
    if not steps and "stop" not in data.get("push", {}):
        allowed = KEYS["push"]["stop"].allowed
        raise SceneError("is missing", file=path, key="push.stop", allowed=allowed)
    scene = Scene(**tables, material=material, path=path)
    scene = _with_push(scene, data.get("push", {}))
    scene = msgspec.structs.replace(scene, steps=_read_steps(scene, steps, path))
    check_together(scene)
    return scene


def _with_push(scene: Scene, given: Mapping[str, Any]) -> Scene:
    """The scene with the start and the step of a control other than the end-shortening filled in."""
    push = scene.push
    if push.control == "end_shortening":
        return scene
    filled: dict[str, Any] = {}
    if "start" not in given:
        filled["start"] = held_value(scene, push.control)
        if filled["start"] is None:
            key = f"{HELD[push.control].table}.{push.control}"
            raise SceneError("is missing, and so is push.start", file=scene.path, key=key,
                             allowed=HELD[push.control].allowed)  # fmt: skip
    if "max_step" not in given:
        filled["max_step"] = _usual_step(scene, push.control)
    return msgspec.structs.replace(scene, push=msgspec.structs.replace(push, **filled))


def _usual_step(scene: Scene, control: str) -> float:
    if HELD[control].needs == "drop":
        scene.require_drop()
    return HELD[control].step(scene)


def _read_steps(scene: Scene, data: Any, path: str | None) -> tuple[Step, ...]:
    """The tables of [[steps]]; what they leave out is that of [push], or of their control."""
    if not isinstance(data, list | tuple) or not all(isinstance(item, Mapping) for item in data):
        raise SceneError(
            "is not a list of tables", file=path, key="steps", value=data, allowed="[[steps]]"
        )
    made = []
    for n, given in enumerate(data):
        item = {"control": scene.push.control, **given}
        control = _read_key(f"steps[{n}].control", KEYS["steps"]["control"], item["control"], path)
        if "max_step" not in item:
            same = control == scene.push.control
            item["max_step"] = scene.push.max_step if same else _usual_step(scene, control)
        step = _read_table("steps", item, path, f"steps[{n}]")
        assert isinstance(step, Step)
        made.append(step)
    return tuple(made)


def replace_keys(scene: Scene, changes: Mapping[str, Any]) -> Scene:
    """See ``Scene.replace``."""
    data: dict[str, Any] = dict(plain_tables(scene))
    if not isinstance(changes, Mapping):
        raise SceneError("is no table of changes", file=scene.path, value=changes)
    for dotted, value in changes.items():
        if not isinstance(dotted, str):
            raise SceneError("is no name of a key", file=scene.path, value=dotted)
        table, dot, name = dotted.partition(".")
        if dot and isinstance(data.setdefault(table, {}), dict):
            data[table][name] = plain(value)
        elif not dot and value is None:
            data.pop(table, None)
        else:
            data[table] = plain(value)
    if "clamps.directors" in changes and "clamps.end_rotation" not in changes:
        data["clamps"].pop("end_rotation", None)  # it was that of other directors, or of none
    if "push.stop" in changes and "push.at" not in changes and "push" not in changes:
        landings = data["push"].pop("at")
        points = build_scene(data, scene.path).push
        low, high = min(points.start, *points.stop), max(points.start, *points.stop)
        data["push"]["at"] = [value for value in landings if low <= value <= high]
    return build_scene(data, scene.path)


def _read_table(
    table: str, data: Mapping[str, Any], path: str | None, called: str | None = None
) -> Table:
    keys, struct = ALL_KEYS[table], TABLES[table]
    called = table if called is None else called
    for name in data:
        if name not in keys:
            raise _unknown_key(table, name, path)
    for name in keys:
        if name in _required(struct) and name not in data:
            allowed = keys[name].allowed
            raise SceneError("is missing", file=path, key=f"{called}.{name}", allowed=allowed)
    values = {name: _read_key(f"{called}.{name}", keys[name], data[name], path) for name in data}
    if "at" in values:
        values["at"] = tuple(sorted(values["at"]))
    if isinstance(values.get("bending"), tuple):
        values["bending"], values["bending_2"] = values["bending"]
    if values.get("directors") is not None:
        start, end = values["directors"]
        values.setdefault("end_rotation", end - start)
    return struct(**values)


def _read_key(key: str, rule: Key, value: Any, path: str | None) -> Any:
    if rule.many == "no" or (rule.many == "or" and not isinstance(value, list)):
        single = _read_value(key, rule, value, path)
        return single if rule.many == "no" else (single,)
    if not isinstance(value, list):
        raise SceneError("is not a list", file=path, key=key, value=value, allowed=rule.allowed)
    if rule.many == "or" and not value:
        raise SceneError("is empty", file=path, key=key, value=value, allowed=rule.allowed)
    return tuple(_read_value(f"{key}[{i}]", rule, item, path) for i, item in enumerate(value))


def _read_value(key: str, rule: Key, value: Any, path: str | None) -> Any:
    try:
        result = rule.read(value)
        if not rule.holds(result):
            raise ValueError("is out of range")
    except ValueError as error:
        raise SceneError(
            str(error), file=path, key=key, value=value, allowed=rule.allowed
        ) from error
    return result


@cache
def _required(struct: type[Table]) -> set[str]:
    return {field.name for field in msgspec.structs.fields(struct) if field.required}


def _unknown_table(name: str, path: str | None) -> SceneError:
    homes = [table for table, keys in ALL_KEYS.items() if name in keys]
    allowed = f"[{homes[0]}] {name}" if homes else f"the tables {_listed(ALL_KEYS)}"
    return SceneError(f"is unknown{_nearest(name, ALL_KEYS)}", file=path, key=name, allowed=allowed)


def _unknown_key(table: str, name: str, path: str | None) -> SceneError:
    homes = [other for other, keys in ALL_KEYS.items() if name in keys]
    hint = f" (it belongs to [{homes[0]}])" if homes else _nearest(name, ALL_KEYS[table])
    return SceneError(
        f"is unknown{hint}",
        file=path,
        key=f"{table}.{name}",
        allowed=f"the keys {_listed(ALL_KEYS[table])} of [{table}]",
    )


def _nearest(name: str, names: Mapping[str, Any]) -> str:
    near = difflib.get_close_matches(name, list(names), n=1)
    return f" (did you mean {near[0]}?)" if near else ""


def _listed(names: Mapping[str, Any]) -> str:
    return ", ".join(names)
