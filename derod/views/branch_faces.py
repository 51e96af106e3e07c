"""Branch files as they look at a prompt and in a notebook: a line; a small table and a picture."""

from __future__ import annotations

from typing import Any

import numpy as np

from derod.branches import BranchFile
from derod.scene.axis import both
from derod.scene.html import html_table
from derod.views.faces import picture_html


class Branches(BranchFile):
    """A branch file with a face; see ``derod.open_branches``."""

    def __repr__(self) -> str:
        state = "" if self.complete else ", not complete"
        return f"<branches {self.path}: {', '.join(self.names) or 'none'}{state}>"

    def _repr_html_(self) -> str:
        rows = [
            (name, len(branch), *_span(branch.table), len(branch.bifurcations), branch.ends)
            for name, branch in self.items()
            if len(branch)
        ]
        head = ("branch", "points", "end-shortening", "t (K0/D^2)", "special points", "ends")
        picture = picture_html(self) if rows else ""
        return html_table(repr(self)[1:-1], head, rows) + picture


def _span(table: np.ndarray) -> tuple[str, str]:
    delta, t = table["end_shortening"], table["end_tension"]
    return (
        f"{both(float(delta.min()), 4)} to {both(float(delta.max()), 4)}",
        f"{t.min():.4g} to {t.max():.4g}",
    )


def open_branches(path: Any) -> Branches:
    """Open a branch file (``derod branch``) for reading: a mapping from names to branches.

    ``file["3D"].table`` has the fields of ``derod.branches.files.layout.POINT`` (units: D, K0/D^2, K0/D),
    ``.positions(i)`` (2k-1, 3) the centre line, ``.arc_length(i)``, ``.drop_center(i)`` (3,),
    ``.bifurcations`` the special points. Raises RecordError.
    """
    return Branches(path)
