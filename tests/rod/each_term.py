"""Every term by itself: its gradient and its Hessian against differences, without compiled kernels.

Bending goes with each, since the arcs of its edges are part of the constraints.

Run with NUMBA_DISABLE_JIT=1; prints one line a term and unknown that is off, and the number of checks.
"""

from __future__ import annotations

import sys
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path

import numpy as np

from derod.rod.terms import TERMS
from derod.rod.terms.writing import ASSEMBLY, written

STEP = 1e-5
STENCIL = ((1, 8 / 12), (-1, -8 / 12), (2, -1 / 12), (-2, 1 / 12))  # of a central difference


def main(folder: Path) -> int:
    from tests.rod import states

    wrong, checks = 0, 0
    for term in list(TERMS):
        path = folder / f"only_{term.name}.py"
        first = TERMS[0]  # bending: the arcs' share of the constraints is differentiated with it
        path.write_text(written(ASSEMBLY.read_text(), [first] if term is first else [first, term]))
        spec = spec_from_file_location(path.stem, path)
        assert spec is not None and spec.loader is not None
        module = module_from_spec(spec)
        spec.loader.exec_module(module)
        states.assembly = module  # type: ignore[attr-defined]
        of_section = term.name in ("section", "torsion")
        for d in (3,) if of_section else (2, 3):
            sample = states.Sample(d, edges=12, section=of_section)
            sample.physics = sample.physics._replace(slides=True, end_tension=1.5)
            bad, done = differences(sample, term.name)
            wrong, checks = wrong + bad, checks + done
    print(f"{checks} checks")
    return wrong


def differences(sample, name: str) -> tuple[int, int]:
    """How many derivatives are off, and how many were looked at."""
    d, w, n = sample.d, sample.w, sample.w * sample.edges
    size = n + sample.d + 5
    end = [n - w + k for k in range(d - 1)]  # the last node moves along the axis only
    angles = w > d + 1
    places = [i for i in range(size) if i not in end][:: 1 if angles else 3 if d == 3 else 2]
    exact = sample.gradient(sample.q, sample.b).copy()
    matrix = sample.dense()
    full = matrix[:size, :size].copy()
    if d == 3 and name == "twist":
        row = matrix[:size, size]
        full -= np.outer(row, row) / matrix[size, size]
    scale = np.abs(exact).max() + 1
    wrong = 0
    slopes = np.zeros((size, size))
    for place in places:
        found, slope = 0.0, np.zeros(size)
        for step, weight in STENCIL:
            q, b = sample.q.copy(), sample.b.copy()
            if place < n:
                q[1 + place // w, place % w] += step * STEP
            else:
                b[place - n] += step * STEP
            found += weight * sample.lagrangian(q, b) / STEP
            slope += weight * sample.gradient(q, b) / STEP
        slope[end] = full[end, place] = 0.0
        slopes[:, place] = slope
        if abs(found - exact[place]) > 2e-8 * scale + 1e-7:
            print(f"{name} in {d}: gradient {place}: {exact[place]!r}, differences {found!r}")
            wrong += 1
        if (
            angles
        ):  # gradients are local: differences have an antisymmetric part, of the angles' moments
            continue
        off = np.abs(slope - full[:, place]).max()
        if off > 2e-7 * (1 + np.abs(full[:, place]).max()):
            print(f"{name} in {d}: Hessian {place} off by {off:.2e}")
            wrong += 1
    if angles:
        full[:, end] = slopes[:, end] = 0.0
        off = np.abs(0.5 * (slopes + slopes.T) - full).max()
        if off > 2e-7 * (1 + np.abs(full).max()):
            print(f"{name} in {d}: Hessian off by {off:.2e}")
            wrong += 1
    return wrong, len(places)


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1])))
