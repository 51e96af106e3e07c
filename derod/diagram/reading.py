"""Diagram files for reading."""

from __future__ import annotations

import os
from typing import Any

from derod.diagram.checking import checked_path, head_check
from derod.diagram.content import Diagram, StoredPath
from derod.diagram.layout import FORMAT, FRAMES, SPECIALS, TABLE, TEXTS
from derod.errors import RecordError
from derod.files import checks
from derod.files.gate import open_gate


def read_diagram(path: str | os.PathLike[str]) -> Diagram:
    """Read a diagram file (``derod trace``, ``derod explore``) whole.

    ``diagram.paths["P1"].table`` has the columns of a run's table. Raises RecordError.
    """
    name = os.fspath(path)
    gate, file = open_gate(name, "a diagram file")
    try:
        with checks.judged(name):
            attributes = checks.attributes(file)
            if attributes.get("format") != FORMAT:
                raise RecordError(f"{name}: is not a diagram file of derod")
            checks.part(file, "paths")
            if head_check(file) != attributes.get("check"):
                raise checks.DamageError("its head does not fit its checksum")
            out = Diagram(
                str(attributes["scene"]), str(attributes["control"]), str(attributes["command"]),
                tuple(str(attributes["stages"]).split()), bool(attributes["complete"]),
                bool(attributes["slides"]),
            )  # fmt: skip
            for one in file["paths"]:
                group, told = checked_path(file, gate, one)
                texts: dict[str, Any] = {text: str(told[text]) for text in TEXTS}
                fields = {part: group[part][:] for part in FRAMES}
                out.paths[one] = StoredPath(
                    one, group[TABLE][:], group[SPECIALS][:], **fields, **texts,
                    whole=bool(told["whole"]),
                )  # fmt: skip
    finally:
        gate.shut()
    return out
