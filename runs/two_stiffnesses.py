"""Two bending stiffnesses: pitchforks of Ax, lowest states, the planar state Pt of a flat strip, and 3D.

    python runs/two_stiffnesses.py [--core 0.01]

l = 10, v0 = 2e-2, f_gamma = 20, rho = 0.1, K3 = 0.9 (all in units of K1 and D). Ax and 3D have d_1 along
e_x at the clamps (alpha_0 = 0): Ax bends about d_1, easily. Pt lies in the other plane; of a strip that
bends easily there alpha_0 is pi/2. Pt runs through the wall's cone, whose core is 0.01 D as the discrete
rod's.
"""

from __future__ import annotations

import argparse
import math
from dataclasses import replace

import numpy as np

from derod.branches.half_rod.mesh import halved
from derod.branches.half_rod.observables import observables
from derod.branches.half_rod.parameters import Parameters
from derod.branches.half_rod.state import HalfRod
from derod.branches.half_rod.wall_core import CORE
from derod.branches.paths.catalogue import Catalogue
from derod.branches.paths.path import Path, PathNotFound
from derod.branches.paths.planar_modes import critical_aspect, critical_twisting, planar_modes
from derod.branches.paths.stability import stability
from derod.branches.paths.straight import NoBuckling
from derod.scene.sections import torsion_factor

RATIOS = (1.0, 2.0, 4.0, 16.0)
DELTAS = (0.1, 0.25, 0.5, 1.0)
PT_DELTAS = (0.25, 0.5, 1.0)
PT_RATIOS = (4.0, 16.0, 1e4)
HALVINGS = 5
LOWEST = 4
ROD = Parameters(wall_strength=2e-2)
SIDEWAYS = 0.5 * math.pi


def traced(parameters: Parameters) -> Catalogue:
    """All named paths of a rod, as far as there are any."""
    catalogue = Catalogue(parameters)
    for work in (
        lambda: [catalogue.ax()],
        catalogue.succession,
        catalogue.stiff,
        lambda: [catalogue.pt()],
        catalogue.triangles,
    ):
        try:
            list(work())
        except (PathNotFound, NoBuckling):
            continue
    return catalogue


def show_pitchforks(catalogues: dict[float, Catalogue]) -> None:
    """Where Ax is left for space curves."""
    print("pitchforks of Ax (alpha_0 = 0), delta/pi and t")
    for ratio, catalogue in catalogues.items():
        found = [special.point.state for _, special in catalogue.paths["Ax"].pitchforks]
        text = ", ".join(
            f"{s.end_shortening / math.pi:.7f} (t = {s.end_tension:.6f})" for s in found
        )
        print(f"  K2/K1 = {ratio:5g}: {text}")


def show_lowest(catalogues: dict[tuple[float, float], Catalogue]) -> None:
    """The lowest flip-symmetric states, of both choices of the flip axis."""
    print("lowest states: K2/K1, delta/pi, path (alpha_0), t, E_hat, unstable modes even + odd")
    for ratio in RATIOS:
        for delta in DELTAS:
            rows = []
            for (own, director), catalogue in catalogues.items():
                if own != ratio:
                    continue
                for path in catalogue.paths.values():
                    rows += [(s, path.name, director) for s in path.landings(delta * math.pi)]
            rows.sort(key=lambda row: observables(row[0])["energy_hat"])
            for state, name, director in rows[:LOWEST]:
                values, modes = observables(state), stability(halved(state))
                print(
                    f"  {ratio:5g} {delta:5g}  {name:6s} ({director / math.pi:3.1f} pi) "
                    f"{values['end_tension']:12.7f} {values['energy_hat']:12.7f}  "
                    f"{modes.even} + {modes.odd + modes.slides}"
                )


def torsion(aspect: float) -> float:
    """K3/K1 = 4 beta of an incompressible rectangle."""
    return 4.0 * float(np.real(torsion_factor({"w": aspect, "h": 1.0})))


def plateau(path: Path, delta: float) -> HalfRod:
    """Pt's state of larger tension, its elements cut in two HALVINGS times."""
    state = max(path.landings(delta), key=lambda s: s.end_tension)
    for _ in range(HALVINGS):
        state = halved(state)
    return state


def show_pt(path: Path, core: float) -> None:
    """The section from which Pt is stable out of its plane, and where it is stable in it."""
    print(f"Pt, bending about d_1 (alpha_0 = pi/2), core of the wall's cone {core:g} D")
    print("  delta/pi            t        E_hat  in plane  K3/K1 stable out of plane at K2/K1 = "
          + ", ".join(f"{r:g}" for r in PT_RATIOS) + ";  w/h of a rectangle")  # fmt: skip
    for delta in PT_DELTAS:
        state = plateau(path, delta * math.pi)
        values, modes = observables(state), planar_modes(state, core)
        found = [critical_twisting(state, ratio, core) for ratio in PT_RATIOS]
        aspect = critical_aspect(state, torsion, core=core)
        words = ", ".join("none" if x is None else f"{x:.6f}" for x in found)
        wide = "none" if aspect is None else f"{aspect:.5f} (K3/K1 = {torsion(aspect):.5f})"
        print(
            f"  {delta:8g} {values['end_tension']:12.7f} {values['energy_hat']:12.7f}  "
            f"{modes.in_even} + {modes.in_odd}     {words};  {wide}"
        )
    print(f"  in-plane flip-breaking ends at delta = {breaking(path, core):.6f} pi")


def breaking(path: Path, core: float) -> float:
    """delta/pi from which Pt has no flip-odd unstable mode in its plane."""
    points = [p for p in path.points if p.state.end_tension > 0.0]
    counts = [planar_modes(p.state, core).in_odd for p in points]
    at = max(i for i in range(len(points) - 1) if counts[i] != counts[i + 1])
    left, low, high = points[at], 0.0, points[at + 1].arc - points[at].arc
    for _ in range(40):
        middle = 0.5 * (low + high)
        state = path.tracer.advance(left, middle, remesh=False).state
        for _ in range(2):
            state = halved(state)
        if planar_modes(state, core).in_odd == counts[at]:
            low = middle
        else:
            high = middle
    return path.tracer.advance(left, high).state.end_shortening / math.pi


def show_space(catalogue: Catalogue) -> None:
    """3D at K2/K1 = 16: its pitchfork, its folds, and the path the rod comes to."""
    print("3D at K2/K1 = 16 (alpha_0 = 0)")
    for name in ("3D", "3D-K2"):
        path = catalogue.paths[name]
        print(f"  {name}: {path.begins} ... {path.ends}")
        joints = [(s, f"pitchfork of {partner}") for _, _, s, partner in path.joints]
        for special, kind in joints + [(s, s.kind) for _, s in path.specials]:
            state = special.point.state
            print(
                f"    {kind:18s} {state.end_shortening / math.pi:.7f} pi, t = {state.end_tension:.6f}, "
                f"E_hat = {observables(state)['energy_hat']:.6f}"
            )
        for first, last in stable_stretches(path):
            print(f"    stable from {first / math.pi:.5f} to {last / math.pi:.5f} pi (points)")


def stable_stretches(path: Path) -> list[tuple[float, float]]:
    """End-shortenings of the first and last of successive stable points."""
    out: list[tuple[float, float]] = []
    before = False
    for point in path.points:
        stable = stability(halved(point.state)).modes == 0
        delta = point.state.end_shortening
        if stable and before:
            out[-1] = (out[-1][0], delta)
        elif stable:
            out.append((delta, delta))
        before = stable
    return out


def main() -> None:
    """Print all of it."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--core", type=float, default=CORE, help="radius of the cone's core, D")
    core = parser.parse_args().core
    catalogues = {
        (ratio, director): traced(replace(ROD, bending_2=ratio, director=director))
        for ratio in RATIOS
        for director in ((0.0,) if ratio == 1.0 else (0.0, SIDEWAYS))
    }
    show_pitchforks({ratio: c for (ratio, director), c in catalogues.items() if director == 0.0})
    show_lowest(catalogues)
    show_pt(catalogues[16.0, SIDEWAYS].paths["Pt"], core)
    show_space(catalogues[16.0, 0.0])


if __name__ == "__main__":
    main()
