"""What a file is, told by its contents: so that a wrong or swapped file is named for what it is."""

from __future__ import annotations

import os
import tomllib
from collections.abc import Collection
from enum import Enum
from pathlib import Path

from derod.exits import UsageError

HDF5 = b"\x89HDF\r\n\x1a\n"
RERUN = b"RRF"
MOST_BYTES = 2**18  # of a scene file


class Kind(Enum):
    """Sorts of files, each as a message names it."""

    RUN = "a run file (derod push)"
    BRANCHES = "a branch file (derod branch)"
    DIAGRAM = "a diagram file (derod trace, derod explore)"
    SCENE = "a scene (TOML)"
    SWEEP = "a sweep (derod sweep)"
    SWEEP_PLAN = "a sweep's plan (TOML)"
    RERUN = "a rerun recording (open it with: rerun FILE)"
    FOLDER = "a folder"
    OTHER = "something else"


SCENES, RUNS, BRANCHES = {Kind.SCENE}, {Kind.RUN}, {Kind.BRANCHES}
DIAGRAMS = {Kind.DIAGRAM}
RESULTS = RUNS | BRANCHES
SWEEPS = {Kind.SWEEP_PLAN}
TABLES = RESULTS | {Kind.SWEEP}

ELSEWHERE = {
    Kind.SCENE: "derod check reads scenes, derod push runs them",
    Kind.RUN: "derod info reads runs, derod push --resume goes on with them",
    Kind.DIAGRAM: "derod info and derod plot read diagram files",
    Kind.BRANCHES: "derod info reads branch files, derod branch --resume goes on with them",
    Kind.SWEEP: "derod info reads sweeps, derod plot -k phase draws them",
    Kind.SWEEP_PLAN: "derod sweep carries it out",
}
"""What reads a file of that kind."""


def kind_of(path: str | os.PathLike[str]) -> Kind:
    """What the file at ``path`` is; OTHER also for what is not there or cannot be read."""
    place = Path(path)
    try:
        if place.is_dir():
            return Kind.FOLDER
        if not place.is_file():  # a pipe, or nothing: reading it might never end
            return Kind.OTHER
        with place.open("rb") as file:
            head = file.read(MOST_BYTES + 1)
    except (OSError, ValueError):
        return Kind.OTHER
    if head.startswith(HDF5):
        return _kind_of_hdf5(os.fsdecode(os.fspath(path)))
    if head.startswith(RERUN):
        return Kind.RERUN
    return _kind_of_toml(head)


def _kind_of_hdf5(path: str) -> Kind:
    from derod.branches import is_branch_file
    from derod.errors import RecordError
    from derod.files import checks
    from derod.files.gate import open_gate
    from derod.record.head import format_of
    from derod.sweeps.files import MARK as SWEEP_MARK

    if is_branch_file(path):
        return Kind.BRANCHES
    from derod.diagram.checking import is_diagram_file

    if is_diagram_file(path):
        return Kind.DIAGRAM
    try:
        gate, file = open_gate(path)
    except RecordError:
        return Kind.OTHER
    try:
        if SWEEP_MARK in file.attrs:
            return Kind.SWEEP
        with checks.judged(path):
            gate.allow(0)
            format_of(path, file)
    except RecordError:
        return Kind.OTHER
    finally:
        gate.shut()
    return Kind.RUN


def _kind_of_toml(head: bytes) -> Kind:
    from derod.scene.reading import TABLES as SCENE_TABLES

    try:
        data = tomllib.loads(head.decode("utf-8-sig"))
    except (ValueError, RecursionError):
        return Kind.OTHER
    if "keys" in data and "scene" in data:
        return Kind.SWEEP_PLAN
    return Kind.SCENE if SCENE_TABLES.keys() & data.keys() else Kind.OTHER


def expect(path: str | os.PathLike[str], wanted: Collection[Kind], what: str = "") -> None:
    """Raise UsageError where the file is of a known kind that is not ``wanted``.

    What it is not, or whether it is there, is left to its reader. ``what`` names the argument.
    """
    kind = kind_of(path)
    if kind in wanted or kind is Kind.OTHER:
        return
    allowed = " or ".join(one.value for one in Kind if one in wanted)
    elsewhere = ELSEWHERE.get(kind)
    raise UsageError(
        f"{os.fspath(path)}: is {kind.value}; allowed{f' for {what}' if what else ''}: {allowed}"
        + (f"; {elsewhere}" if elsewhere else "")
    )


def default_output(scene: str, ending: str) -> str:
    """The file that results of a scene go to by default: beside it, or here for a shipped one."""
    from derod import scenes

    if scenes.is_shipped(scene):
        return f"{scene}{ending}"
    path = Path(scene)
    return os.fspath(path.with_name(f"{path.name.removesuffix('.toml')}{ending}"))
