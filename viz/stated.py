"""Our values beside those that the paper states, as a table in Markdown.

``python viz/stated.py viz/out/data``: the folder that viz/paper.py fills.
"""

from __future__ import annotations

import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

import derod
from derod.views.plots.reading import HARD_WALL, planar_intervals

HEAD = (
    "| quantity | paper | branches, $v_0 = 2\\cdot10^{-4}$ | push | "
    "branches, $v_0 = 2\\cdot10^{-2}$ | push |\n|---|---|---|---|---|---|\n"
)


def stated_table(runs: Mapping[str, Any], files: Mapping[str, Any]) -> str:
    """The table; ``runs`` and ``files`` hold both scenes, "text" and "figures"."""
    columns = []
    for name in ("text", "figures"):
        columns.append(branch_values(files[name]))
        columns.append(run_values(runs[name]))
    rows = (
        ("buckling, $t$", "3.7"),
        ("planar to space, $\\delta/\\pi$", "0.24"),
        ("space to planar ($L_2$), $\\delta/\\pi$", "1.9"),
        ("planar ($L_2$) to space, $\\delta/\\pi$", "2.15"),
        ("plateau, $t$ ($P_t$ at $1.5\\pi$; $f_\\gamma-2$)", "18"),
    )
    lines = [
        f"| {label} | {paper} | " + " | ".join(column[k] for column in columns) + " |"
        for k, (label, paper) in enumerate(rows)
    ]
    return HEAD + "\n".join(lines) + "\n"


def branch_values(file: Any) -> list[str]:
    """The five values from a branch file."""
    first = file["Ax"].table[0]
    out = [f"{first['end_tension']:.3f} (at {first['end_shortening'] / np.pi:.4f} π)"]
    out.append(_pitchfork(file["Ax"], "3D"))
    out.append(_pitchfork(file["L2"], "3D"))
    out.append(_pitchfork(file["L2"], "3D-L2"))
    if "Pt" in file:
        table = file["Pt"].table
        near = table[
            np.argmin(abs(table["end_shortening"] / np.pi - 1.5) + (table["end_tension"] < 5))
        ]
        out.append(f"{near['end_tension']:.2f}")
    else:
        out.append("not found")
    return out


def _pitchfork(branch: Any, partner: str) -> str:
    for row in branch.bifurcations:
        if row["kind"].decode() == "pitchfork" and row["partner"].decode() == partner:
            return f"{row['end_shortening'] / np.pi:.5f}"
    return "not found"


def run_values(run: Any) -> list[str]:
    """The same from a push: between which increments it leaves the plane and comes back."""
    table = run.table
    delta = table["end_shortening"] / np.pi
    out = [f"{table['end_tension'][0]:.3f} (at {delta[0]:.4f} π)"]
    spans = [(a / np.pi, b / np.pi) for a, b in planar_intervals(run)]
    first = next((span for span in spans if span[0] < 0.1), None)
    spool = next((span for span in spans if span[0] > 1.0), None)
    out.append(_between(delta, first[1], after=True) if first else "not found")
    out.append(_between(delta, spool[0], after=False) if spool else "not reached")
    out.append(_between(delta, spool[1], after=True) if spool else "not reached")
    out.append(f"$f_\\gamma-2$ = {run.scene.drop.capillary_force - HARD_WALL:g}")
    return out


def _between(delta: np.ndarray, at: float, *, after: bool) -> str:
    i = int(np.argmin(abs(delta - at)))
    j = min(i + 1, len(delta) - 1) if after else max(i - 1, 0)
    low, high = sorted((delta[i], delta[j]))
    return f"{low:.3f} to {high:.3f}"


def main() -> int:
    """Print the table."""
    if len(sys.argv) != 2:
        print(__doc__, file=sys.stderr)
        return 2
    data = Path(sys.argv[1])
    names = ("text", "figures")
    runs = {name: derod.open_run(data / f"{name}.h5") for name in names}
    files = {name: derod.open_branches(data / f"{name}-branches.h5") for name in names}
    print(stated_table(runs, files), end="")
    return 0


if __name__ == "__main__":
    sys.exit(main())
