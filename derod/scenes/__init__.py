"""The scenes that ship with derod: ``derod push quick``, ``derod.push("quick")``.

Each is a TOML file in this folder whose first line says in a sentence what it shows.
"""

from __future__ import annotations

import difflib
import os
from importlib import resources
from pathlib import Path
from typing import TYPE_CHECKING

from derod.errors import SceneError

if TYPE_CHECKING:
    from derod.scene import Scene

NEW = "_new"
"""The commented scene that ``derod init`` writes."""
ENDING = ".toml"


def names() -> tuple[str, ...]:
    """The names of the shipped scenes, the first look first."""
    found = (entry.name for entry in resources.files(__package__).iterdir())
    scenes = {name.removesuffix(ENDING) for name in found if name.endswith(ENDING)} - {NEW}
    return tuple(sorted(scenes, key=lambda name: (name != "quick", name)))


def text(name: str) -> str:
    """The text of a shipped scene, or of ``NEW``. Raises SceneError."""
    if name not in (*names(), NEW):
        raise SceneError(
            "is no scene that ships with derod", value=name, allowed=", ".join(names())
        )
    return (resources.files(__package__) / f"{name}{ENDING}").read_text(encoding="utf-8")


def headline(name: str) -> str:
    """What a shipped scene shows, in a sentence: its first line."""
    return text(name).splitlines()[0].removeprefix("#").strip()


def is_shipped(place: str | os.PathLike[str]) -> bool:
    """Whether ``place`` is the name of a shipped scene, and no file's."""
    name = os.fspath(place)
    return isinstance(name, str) and name in names() and not os.path.lexists(name)


def file_of(place: str | os.PathLike[str]) -> str:
    """The path of the file that ``place`` names: itself, or that of a shipped scene."""
    name = os.fsdecode(os.fspath(place))
    if not is_shipped(name):
        return name
    return os.fspath(Path(str(resources.files(__package__))) / f"{name}{ENDING}")


def read_scene(place: str | os.PathLike[str]) -> Scene:
    """The scene of a TOML file, or of a shipped one by its name.

    A file comes first where there is one. Raises SceneError, which says what was meant perhaps.
    """
    from derod.scene import load_scene, parse_scene

    if is_shipped(place):
        return parse_scene(text(os.fspath(place)), path=os.fspath(place))
    try:
        return load_scene(place)
    except SceneError as error:
        hint = _meant(place) if isinstance(error.__cause__, FileNotFoundError) else None
        if hint is None:
            raise
        raise SceneError(
            "cannot be read: there is no such file, and no scene of that name ships with derod",
            file=error.file,
            allowed=hint,
        ) from error


def _meant(place: str | os.PathLike[str]) -> str | None:
    """What is allowed where ``place`` names no file; None where it was meant as a path."""
    name = Path(os.fsdecode(os.fspath(place)))
    stem = name.name.removesuffix(ENDING)
    if stem in names():
        return f"a file's path, or {stem} (shipped, without folder and ending)"
    if name.parent != Path() or name.suffix:
        return None
    near = difflib.get_close_matches(stem, names(), 1)
    return f"a file's path, or {near[0] if near else ', '.join(names())}"
