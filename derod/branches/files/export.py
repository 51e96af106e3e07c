"""Branches as the text table that AUTO users expect: the columns of a b.-file with labelled
special points."""

from __future__ import annotations

import numpy as np

from derod.branches.files.record import BranchFile
from derod.branches.files.stored import StoredBranch

TYPES = {"pitchfork": 1, "fold": 5, "buckling": 1}
"""AUTO's type numbers: 1 branch point (BP), 5 limit point (LP), 9 end point (EP)."""
END_POINT = 9
COLUMNS = (
    ("PAR(delta)", "end_shortening"),
    ("t", "end_tension"),
    ("E_hat", "energy_hat"),
    ("E_tot", "energy_total"),
    ("2 sigma", "wetted_length"),
    ("f_B", "meniscus_force"),
    ("y_C", "drop_y"),
    ("error", "error"),
)


def auto_table(file: BranchFile) -> str:
    """All branches of a file: BR PT TY LAB and the COLUMNS, one line a point.

    As in AUTO, PT is negative on points with no unstable mode, TY and LAB are zero on ordinary
    points, lines of a header start with branch number 0.
    """
    label = 0
    lines = [f"   0 derod branches of {_constants(file)}"]
    for number, branch in enumerate(file.values(), start=1):
        lines.append(f"   0 {branch.name}: begins {branch.begins}; ends {branch.ends}")
        names = "".join(f"{title:>20s}" for title, _ in COLUMNS)
        lines.append(f"   0    PT  TY  LAB{names}")
        kinds = _types(branch)
        for i, row in enumerate(branch.table):
            label += bool(kinds[i])
            point = -(i + 1) if row["unstable_modes"] == 0 else i + 1
            values = "".join(f"{row[name]:20.10E}" for _, name in COLUMNS)
            lines.append(f"{number:4d}{point:6d}{kinds[i]:4d}{label if kinds[i] else 0:5d}{values}")
    return "\n".join(lines) + "\n"


def _types(branch: StoredBranch) -> np.ndarray:
    """AUTO's type number of every point."""
    out = np.zeros(len(branch), dtype=int)
    out[0] = out[-1] = END_POINT
    for special in branch.bifurcations:
        out[special["index"]] = TYPES[special["kind"].decode()]
    return out


def _constants(file: BranchFile) -> str:
    p = file.parameters
    return (
        f"l = {p.length:g}, k3 = {p.twisting:g}, f_gamma = {p.capillary_force:g}, "
        f"v0 = {p.wall_strength:g}, rho = {p.wall_softness:g}, R = {p.end_rotation:g}"
        + (f", W = {p.weight:g}" if p.weight else "")
        + (f", K2/K1 = {p.bending_2:g}, alpha_0 = {p.director:g}" if p.anisotropic else "")
    )
