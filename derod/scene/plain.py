"""A scene as TOML would give it: nested tables of plain values."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from derod.scene.material import derived, plain_material
from derod.scene.tables import Material, Scene, Table, written_fields
from derod.scene.units import Measured


def plain_tables(scene: Scene) -> dict[str, Any]:
    """The scene as nested tables of plain values; ``build_scene`` gives an equal scene.

    What [material] gives is left out of [rod] and [drop].
    """
    known = {} if scene.material is None else derived(scene.material)
    tables: dict[str, Any] = {
        table: plain_material(struct)
        if isinstance(struct, Material)
        else {
            name: plain(value)
            for name, value in written_fields(struct).items()
            if not comes_from(known, table, name, value)
        }
        for table, struct in scene.tables().items()
    }
    if scene.steps:
        tables["steps"] = [plain(step) for step in scene.steps]
    return tables


def comes_from(
    known: Mapping[tuple[str, str], Measured], table: str, name: str, value: Any
) -> bool:
    """Whether what [material] gives (``derived``) is the value of a key; of [K1, K2] it gives both."""
    if name == "bending" and isinstance(value, tuple):
        value = value[0]
    return (table, name) in known and bool(known[table, name].value == value)


def plain(value: Any) -> Any:
    """``value`` as TOML would give it: tables, lists and numbers of numpy's and ours made plain."""
    if isinstance(value, Material):
        return plain_material(value)
    if isinstance(value, Table):
        return {name: plain(item) for name, item in written_fields(value).items()}
    if isinstance(value, Mapping):
        return {name: plain(item) for name, item in value.items()}
    if isinstance(value, tuple | list):
        return [plain(item) for item in value]
    if type(value).__module__ == "numpy" and hasattr(value, "tolist"):
        return plain(value.tolist())
    return value
