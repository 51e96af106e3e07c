"""The flip-symmetric states of a heavy drop at given end-shortenings, of all sheets that can be loaded."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property

from derod.branches.half_rod.mirror import FULL, Mirror
from derod.branches.half_rod.observables import SCALED, observables
from derod.branches.half_rod.outcome import NotConverged
from derod.branches.half_rod.parameters import Parameters
from derod.branches.half_rod.state import HalfRod
from derod.branches.half_rod.symmetry import plane
from derod.branches.half_rod.threads import one_blas_thread
from derod.branches.paths.arc import Control
from derod.branches.paths.catalogue import UPSIDE_DOWN, Catalogue
from derod.branches.paths.path import Path, PathNotFound
from derod.branches.paths.special import SpuriousPoint
from derod.branches.paths.stability import Stability, stability
from derod.branches.paths.straight import NoBuckling
from derod.branches.paths.weight import hung, loaded

SAME = 1e-6
"""States are one if t, E_hat (relative, or to 1), y_C and wetted length are this near."""
COMPARED = ("end_tension", "energy_hat", "drop_y", "wetted_length")


@dataclass(frozen=True, eq=False)
class HeavyState:
    """A settled state of a heavy drop.

    ``origin``: the weightless path that it was loaded on, with "-up" where upside down; several
    origins lead to one state, the first is kept. ``values``: what ``observables`` gives, in D, K0.
    """

    origin: str
    state: HalfRod
    values: dict[str, float]

    @property
    def planar(self) -> bool:
        """Whether the rod lies in the vertical plane."""
        return plane(self.state) is not None

    @cached_property
    def stability(self) -> Stability:
        """Unstable modes, flip-even and flip-odd (rolling among these), and whether the drop slides."""
        return stability(self.state)


@one_blas_thread
def heavy_states(
    parameters: Parameters,
    deltas: Iterable[float],
    control: Control | None = None,
    paths: Iterable[str] = ("Ax", "3D", "L", "Tri"),
) -> dict[float, list[HeavyState]]:
    """States of weight ``parameters.weight`` at the end-shortenings ``deltas`` (D), by their energy.

    Every state of the weightless ``paths`` (families) at such an end-shortening is turned both ways
    and continued in the weight at fixed end-shortening, through folds, each passage of the weight
    being one state. What is not connected so is not found: these are sheets, not all solutions.
    Residuals are below ``control.tolerance`` (1e-10). Raises PathNotFound for a weightless drop, NoBuckling
    where the straight rod does not buckle.
    """
    if parameters.weight == 0.0:
        raise PathNotFound("a drop without weight has no heavy states: see derod branch")
    control = control or Control()
    catalogue = Catalogue(parameters.with_weight(0.0), control)
    families = set(paths)
    traced = _weightless(catalogue, families)
    start = next(iter(catalogue.paths.values())).points[0].state
    return {float(delta): _at(traced, start, parameters, float(delta), control) for delta in deltas}


def _weightless(catalogue: Catalogue, families: set[str]) -> list[Path]:
    """The weightless paths of the families asked for."""
    try:
        if not catalogue.twisted:
            catalogue.ax()
        if families & {"3D", "L"}:
            list(catalogue.succession())
        if "Tri" in families and not catalogue.twisted:
            list(catalogue.triangles())
        if "Pt" in families and not catalogue.twisted:
            catalogue.pt()
    except NoBuckling:
        raise
    except (PathNotFound, NotConverged, SpuriousPoint):
        pass  # what was traced until then is used
    heads = tuple(families)
    return [path for name, path in catalogue.paths.items() if name.startswith(heads)]


def _at(
    traced: list[Path], start: HalfRod, parameters: Parameters, delta: float, control: Control
) -> list[HeavyState]:
    """The states at one end-shortening, each once; ``start``: where all weightless paths come from."""
    out: list[HeavyState] = []
    for path in traced:
        for light in path.landings(delta):
            for upside_down in (False, True):
                origin = path.name + (UPSIDE_DOWN if upside_down else "")
                turned = hung(light, start, upside_down=upside_down)
                for state in _loaded(turned, path.tracer.mirror, parameters, control):
                    found = HeavyState(origin, state, _values(state))
                    if not any(_same(found, other) for other in out):
                        out.append(found)
    return sorted(out, key=lambda found: found.values["energy_hat"])


def _loaded(
    light: HalfRod, mirror: Mirror, parameters: Parameters, control: Control
) -> list[HalfRod]:
    """The states of a weightless one with the weight added; a point-symmetric curve leaves its plane."""
    own = mirror if mirror.carries_weight else FULL
    try:
        found = loaded(light, parameters.weight, own, control, first=False)
    except NotConverged:
        return []
    return [settled.state.with_parameters(parameters) for settled in found]


def _values(state: HalfRod) -> dict[str, float]:
    values = observables(state)
    for name in SCALED:
        values[name] *= state.parameters.bending
    return values


def _same(a: HeavyState, b: HeavyState) -> bool:
    """Whether two states agree in COMPARED to SAME: one state, or its mirror image."""
    pairs = [(a.values[name], b.values[name]) for name in COMPARED]
    return all(abs(x - y) <= SAME * max(1.0, abs(y)) for x, y in pairs)
