"""Write the sums over the terms into ``rod.assembly``, flat and in the order of the list.

    python -m derod.rod.terms.writing

Nested calls would say the same and compile twice as long (every inlined layer is compiled anew);
tests hold the file against the list.
"""

from __future__ import annotations

import re
import sys
from collections.abc import Sequence
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path

from derod.rod.terms import TERMS
from derod.rod.terms.term import Term

ASSEMBLY = Path(__file__).parents[1] / "assembly.py"
CONDITIONS = {"drop": "physics.drop", "space": "len(physics.axis) == 3"}
BLOCK = re.compile(r"^( *)# terms: (\w+)\n.*?^ *# end\n", re.MULTILINE | re.DOTALL)


def written(text: str, terms: Sequence[Term]) -> str:
    """Return the assembly's text with its sums over ``terms``."""
    return BLOCK.sub(lambda match: _block(match[1], match[2], terms), text)


def _block(indent: str, what: str, terms: Sequence[Term]) -> str:
    lines = {
        "imports": _imports,
        "energy": _energies,
        "breaks_turn": _symmetry,
        "add_gradient": _adding,
        "add_hessian": _adding,
    }[what](what, terms)
    inside = "".join(f"{indent}{line}\n" if line else "\n" for line in lines)
    return f"{indent}# terms: {what}\n{inside}{indent}# end\n"


def _imports(_: str, terms: Sequence[Term]) -> list[str]:
    homes: dict[str, list[str]] = {}
    for term in terms:
        homes.setdefault(term.module.rpartition(".")[0], []).append(term.name)
    lines = [
        f"from {home} import {', '.join(sorted(names))}" if home else f"import {names[0]}"
        for home, names in sorted(homes.items())
    ]
    return [*lines, ""]


def _energies(_: str, terms: Sequence[Term]) -> list[str]:
    lines = ["return ("]
    for term in terms:
        condition = f" if {CONDITIONS[term.needs]} else 0.0" if term.needs else ""
        lines.append(f"    {term.name}.energy(physics, kin, q, b, psi){condition},")
    return [*lines, ")"]


def _adding(what: str, terms: Sequence[Term]) -> list[str]:
    lines = []
    slot = {"add_gradient": "grad", "add_hessian": "hess"}[what]
    for term in terms:
        if term.needs:
            lines.append(f"if {CONDITIONS[term.needs]}:")
        call = f"{term.name}.{what}(physics, kin, q, b, psi, tension, {slot})"
        lines.append(f"    {call}" if term.needs else call)
    return lines


def _symmetry(_: str, terms: Sequence[Term]) -> list[str]:
    breaking = [f"physics.{term.breaks_turn} == 0.0" for term in terms if term.breaks_turn]
    return [f"return {' and '.join(breaking) or 'True'}"]


def add(term: Term, folder: Path) -> None:
    """Put one more term on the list, before the sums are imported; they are written to ``folder``.

    For terms of one's own, outside this package: see CONTRIBUTING.md. Compiled kernels must lie in a folder
    of their own too (``NUMBA_CACHE_DIR``).
    """
    if "derod.rod.assembly" in sys.modules:
        raise RuntimeError("terms must be added before derod.rod.assembly is imported")
    TERMS.append(term)
    path = folder / "assembly.py"
    path.write_text(written(ASSEMBLY.read_text(), TERMS))
    spec = spec_from_file_location("derod.rod.assembly", path)
    assert spec is not None and spec.loader is not None
    module = module_from_spec(spec)
    sys.modules["derod.rod.assembly"] = module
    spec.loader.exec_module(module)


if __name__ == "__main__":
    ASSEMBLY.write_text(written(ASSEMBLY.read_text(), TERMS))
