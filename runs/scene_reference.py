"""Write the reference of scene files, docs/scenes.md, from the keys themselves.

python runs/scene_reference.py            # writes it
python runs/scene_reference.py --check    # exit code 1 where the page is not what the keys say
"""

from __future__ import annotations

import inspect
import re
import sys
from pathlib import Path

import msgspec
from pages import write_or_check

from derod.scene import tables
from derod.scene.material import MATERIAL_KEYS
from derod.scene.quantities import write_quantity
from derod.scene.reading import TABLES
from derod.scene.rules import KEYS

PAGE = Path(__file__).parents[1] / "docs" / "scenes.md"
HEAD = """# Scene files

A scene is a TOML file of these tables. `derod init my.toml` writes one with comments, `derod check` validates
one, and every error names the file, the key, the value and what is allowed. Lengths are in drop diameters D,
forces in K0/D^2, energies in K0/D, angles in radians; angles and lengths may be written as "2.8 pi". A key
without a default must be there. This page is written by `python runs/scene_reference.py` from the keys.
"""


def meanings(struct: type) -> dict[str, str]:
    """What each field of a table means: the text that stands below it."""
    source = inspect.getsource(struct)
    found = re.findall(
        r"^    (\w+): [^\n]*\n    \"\"\"(.*?)\"\"\"", source, re.MULTILINE | re.DOTALL
    )
    return {name: " ".join(text.split()).replace("``", "`") for name, text in found}


def default(field: msgspec.structs.FieldInfo) -> str:
    """A field's default as a scene would say it."""
    if field.required:
        return "required"
    value = getattr(field.default, "value", field.default)
    if value is None:
        return "none"
    if isinstance(value, tuple):
        return "`[]`"
    text = write_quantity(value) if isinstance(value, float) else repr(value)
    return f"`{text}`".lower()


def section(name: str) -> list[str]:
    """One table of the file."""
    struct = TABLES[name]
    title = f"[[{name}]]" if name == "steps" else f"[{name}]"
    lines = [f"## {title}", "", " ".join((struct.__doc__ or "").split()).replace("``", "`"), ""]
    lines += ["| key | meaning | default | allowed |", "|---|---|---|---|"]
    told, keys = meanings(struct), KEYS.get(name, MATERIAL_KEYS)
    for field in msgspec.structs.fields(struct):
        if field.name not in keys:  # derived from others
            continue
        allowed = keys[field.name].allowed
        cells = (f"`{field.name}`", told.get(field.name, ""), default(field), allowed)
        lines.append("| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |")
    return [*lines, ""]


def page() -> str:
    """The whole page."""
    order = [name for name in tables.Scene.__struct_fields__ if name in TABLES]
    return "\n".join([HEAD, *(line for name in order for line in section(name))])


if __name__ == "__main__":
    sys.exit(write_or_check(PAGE, page, (__doc__ or "").splitlines()[0]))
