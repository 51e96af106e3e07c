"""What is in a branch file, in lines of text, for ``derod info``."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from derod.scene.axis import both

if TYPE_CHECKING:
    from derod.branches import BranchFile

HEAD = (
    "  name     points  delta, D                delta/pi                t, K0/D^2             error"
)


def branch_lines(file: BranchFile) -> Iterator[str]:
    """The parameters, the branches, their special points, and whether all are there."""
    p = file.parameters
    state = "complete" if file.complete else "not complete (derod branch --resume goes on)"
    yield f"{file.path}: {len(file)} branches, {state}"
    section = f", K2/K = {p.bending_2:g}, alpha_0 = {p.director:g}" if p.anisotropic else ""
    yield f"  rod   l = {p.length:g}, K = {p.bending:g}, k3 = {p.twisting:g}{section}"
    yield (
        f"  drop  f_gamma = {p.capillary_force:g}, v0 = {p.wall_strength:g}, "
        f"rho = {p.wall_softness:g}" + (f", W = {p.weight:g}" if p.weight else "")
    )
    yield f"  end rotation {p.end_rotation:.6g} rad ({p.end_rotation / math.pi:.6g} pi)"
    if not len(file):
        return
    yield "branches (error: the largest by halving the mesh, of t and E_hat relative)"
    yield HEAD
    for name, branch in file.items():
        if not len(branch):
            yield f"  {name:8} {0:6d}"
            continue
        table = branch.table
        delta, t = table["end_shortening"], table["end_tension"]
        yield (
            f"  {name:8} {len(branch):6d}  {_span(delta):22}  {_span(delta / math.pi):22}  "
            f"{_span(t):20}  {np.max(table['error']):.1e}"
        )
    for name, branch in file.items():
        yield f"{name}: {branch.begins} ... {branch.ends}"
        yield f"  {_stability(branch.table['unstable_modes'])}"
        for special in branch.bifurcations:
            partner = special["partner"].decode()
            where = both(float(special["end_shortening"]))
            yield (
                f"  {special['kind'].decode():12} {where}, t = {special['end_tension']:.6g}, "
                f"E_hat = {special['energy_hat']:.6g}" + (f", with {partner}" if partner else "")
            )
        for remark in branch.remarks:
            yield f"  {remark}"


def _span(values: np.ndarray) -> str:
    return f"{np.min(values):.6g} to {np.max(values):.6g}"


def _stability(modes: np.ndarray) -> str:
    if np.any(modes < 0):
        return "unstable modes were not counted at all points"
    stable = np.count_nonzero(modes == 0)
    return f"{stable} of {len(modes)} points stable, at most {np.max(modes)} unstable modes"
