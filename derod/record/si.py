"""Runs read back in SI: m, N, J, N m, rad, by the drop's diameter D and the stiffness K0 of [material].

The units of a run file (``record.layout``) say what is scaled by what: D by D, K0 D-2 by K0/D^2, K0 D-1
by K0/D (eq:adim). Angles, counts, flags and times stay as they are.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from derod.errors import SceneError
from derod.record import layout
from derod.scene import Scene
from derod.scene.material import inputs
from derod.scene.sections import stiffness

if TYPE_CHECKING:
    from derod.record.run import BaseRun

SHOWN = {"m": ("um", 1e-6), "N": ("uN", 1e-6), "J": ("pJ", 1e-12)}
"""Units in which ``derod info --si`` shows what is stored in SI."""

LANDING_COLUMNS = ("end_shortening", "wetted_length", "end_tension", "force_a", "energy_hat")


@dataclass(frozen=True, slots=True)
class Scales:
    """The units of a dimensionless scene, in SI."""

    length: float
    """D, m."""
    stiffness: float
    """K0, N m^2."""

    @property
    def force(self) -> float:
        """K0/D^2, N."""
        return self.stiffness / self.length**2

    @property
    def energy(self) -> float:
        """K0/D, J; of moments too, N m."""
        return self.stiffness / self.length

    def of(self, unit: str | None) -> tuple[float, str]:
        """What a value in a run file's ``unit`` is multiplied by, and the SI unit it then has."""
        table = {
            "D": (self.length, "m"),
            "K0 D-2": (self.force, "N"),
            "K0 D-1": (self.energy, "J"),
        }
        return table.get(unit or "", (1.0, unit or ""))


def scales(scene: Scene) -> Scales:
    """The SI units of ``scene``; raises SceneError where it has no [material]."""
    if scene.material is None:
        raise SceneError(
            "is missing: without it nothing says what D and K0 are",
            file=scene.path,
            key="material",
            allowed="a scene with [material] (docs/si.md)",
        )
    return Scales(
        length=scene.material.drop_diameter.value,
        stiffness=stiffness({k: x.value for k, x in inputs(scene.material).items()}).real,
    )


class SIReading:
    """What ``run.si`` gives: the run's arrays in SI, under the run's own names."""

    def __init__(self, run: BaseRun) -> None:
        self._run = run
        self.scales = scales(run.scene)

    @property
    def units(self) -> dict[str, str]:
        """The SI unit of each column of ``table``; "" for counts and flags."""
        names = self._run.table.dtype.names or ()
        return {name: self._scale(name)[1] for name in names}

    @property
    def table(self) -> np.ndarray:
        """``run.table`` in SI, a new array of the same dtype."""
        return self._scaled(self._run.table)

    @property
    def extrapolated(self) -> np.ndarray | None:
        """``run.extrapolated`` in SI, values and errors; None where there is none."""
        rows = self._run.extrapolated
        return None if rows is None else self._scaled(rows)

    def __getitem__(self, name: str) -> np.ndarray:
        """One column of ``table``, in SI."""
        factor, _ = self._scale(name)
        column: np.ndarray = self._run.table[name]
        return column * factor if column.dtype.kind == "f" else column.copy()

    def positions(self, i: int) -> np.ndarray:
        """Nodes of increment ``i``, (N+1, 3), m."""
        return self._run.positions(i) * self.scales.length

    def arc_length(self, i: int) -> np.ndarray:
        """Arc length of the nodes of increment ``i``, (N+1,), m."""
        return self._run.arc_length(i) * self.scales.length

    def edge_tension(self, i: int) -> np.ndarray:
        """Tension in the edges of increment ``i``, (N,), N."""
        return self._run.edge_tension(i) * self.scales.force

    def drop_center(self, i: int) -> np.ndarray:
        """Centre of the drop at increment ``i``, (3,), m."""
        return self._run.drop_center(i) * self.scales.length

    def _scale(self, name: str) -> tuple[float, str]:
        return self.scales.of(layout.ROW_UNITS.get(name.removesuffix("_error")))

    def _scaled(self, rows: np.ndarray) -> np.ndarray:
        result = rows.copy()
        for name in rows.dtype.names or ():
            if rows.dtype[name].kind == "f":
                result[name] *= self._scale(name)[0]
        return result


def si_lines(run: BaseRun) -> Iterator[str]:
    """The units, the landings and the ranges of ``run`` in micrometres, micronewtons, picojoules."""
    reading = SIReading(run)
    unit = reading.scales
    yield (
        f"in SI: D = {unit.length:.6g} m, K0 = {unit.stiffness:.6g} N m^2, "
        f"K0/D^2 = {unit.force:.6g} N, K0/D = {unit.energy:.6g} J"
    )
    if not len(run):
        return
    table, units = reading.table, reading.units
    heads = [f"{name} {SHOWN[units[name]][0]}" for name in LANDING_COLUMNS]
    yield "  increment   delta/pi" + "".join(f"{head:>20}" for head in heads)
    wanted = table["landing"].copy()
    wanted[-1] = True
    for row, plain in zip(table[wanted], run.table[wanted], strict=True):
        values = [row[name] / SHOWN[units[name]][1] for name in LANDING_COLUMNS]
        yield (
            f"  {row['increment']:9d} {plain['end_shortening'] / math.pi:10.5f}"
            + "".join(f"{value:20.6g}" for value in values)
        )
    yield "ranges"
    for name in table.dtype.names or ():
        if units[name] in SHOWN:
            symbol, size = SHOWN[units[name]]
            low, high = np.min(table[name]) / size, np.max(table[name]) / size
            yield f"  {name:18}{low:12.6g} to {high:.6g} {symbol}"
