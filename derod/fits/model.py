"""What a scene says of measured data: one push that lands on every displacement, and its derivatives.

In SI the forces are t K0/D^2 and the displacements delta D, with the K0 and D of the parameters tried: a free
``material.young_modulus`` moves both the rod and its units.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from derod.errors import DerodError, SceneError
from derod.fits.data import Data
from derod.pushing.frames import Outcome
from derod.scene import Scene
from derod.scene.experiment import unit_force
from derod.scene.material import inputs
from derod.scene.tables import Material
from derod.sweeps.points import pushed

STEP = 1e-4
"""Of the differences, relative: rounding gives 1e-9/STEP, the third derivative STEP^2."""
JUMP = 0.5
"""Where the slopes to both sides differ by more of the largest slope, the state jumps on one side."""
SAME = 1e-9
"""D: displacements closer than that are one landing."""
Jacobian = Callable[["Model", np.ndarray], np.ndarray]


class NoCurveError(DerodError):
    """Values at which the push does not come to the end of the data."""


@dataclass
class Model:
    """The forces of ``data`` as a function of the free values of a scene."""

    scene: Scene
    keys: Sequence[str]
    data: Data
    pushes: int = 0
    _known: dict[bytes, np.ndarray] = field(default_factory=dict)

    def scene_at(self, values: np.ndarray) -> Scene:
        """The scene with these values (p,). Raises SceneError."""
        return self.scene.replace(dict(zip(self.keys, map(float, values), strict=True)))

    def __call__(self, values: np.ndarray) -> np.ndarray:
        """The forces (n,) in the data's unit. Raises SceneError, NoCurveError."""
        values = np.asarray(values, dtype=float)
        name = values.tobytes()
        if name not in self._known:
            if len(self._known) > 64:
                self._known.clear()
            self._known[name] = self._push(values)
        return self._known[name]

    def _push(self, values: np.ndarray) -> np.ndarray:
        scene = self.scene_at(values)
        length, force = units_of(scene) if self.data.si else (1.0, 1.0)
        places = self.data.displacement / length
        landings = distinct(places)
        start = min(scene.push.start, float(landings[0]))
        stop = float(landings[-1])
        inner = [float(x) for x in landings if start < x < stop]
        path = {"push.start": start, "push.stop": stop, "push.at": inner}
        if start == stop:  # a single place: come from a little before
            path["push.start"] = 0.5 * stop
        self.pushes += 1
        with pushed(scene.replace(path)) as run:
            if run.outcome is not Outcome.COMPLETED:
                assert run.ending is not None
                raise NoCurveError(f"the push to {stop:.6g} D ended early: {run.ending.message}")
            rows = run.table[run.table["landing"]]
            nearest = np.searchsorted(rows["end_shortening"], places - SAME)
            return np.asarray(rows["end_tension"][nearest] * force)


def units_of(scene: Scene) -> tuple[float, float]:
    """D in m and K0/D^2 in N. Raises SceneError where the scene has no [material]."""
    material: Material | None = scene.material
    if material is None:
        raise SceneError("is missing: the data are in SI", file=scene.path, key="material",
                         allowed="a scene with [material], or data in D and K0/D^2")  # fmt: skip
    given: Mapping[str, complex] = {name: x.value for name, x in inputs(material).items()}
    return material.drop_diameter.value, unit_force(given).real


def distinct(places: np.ndarray) -> np.ndarray:
    """Increasing places, those closer than ``SAME`` to the one before left out."""
    kept = [places[0]]
    for place in places[1:]:
        if place - kept[-1] > SAME:
            kept.append(place)
    return np.array(kept)


def differences(model: Model, values: np.ndarray) -> np.ndarray:
    """d force/d value (n, p) by central differences, one-sided where the state jumps on the other side.

    A jump (a snap, or a corner at a pitchfork that passes the place) shows in slopes to both sides that
    differ: there the smaller one is taken. Where only one side can be pushed it is taken alone. Raises
    NoCurveError where neither can.
    """
    here = model(values)
    columns = []
    for k, value in enumerate(values):
        step = STEP * (abs(value) or 1.0)
        sides = []
        for sign in (1.0, -1.0):
            there = np.array(values, dtype=float)
            there[k] += sign * step
            try:
                sides.append((model(there) - here) / (there[k] - value))
            except (SceneError, NoCurveError):
                continue
        if not sides:
            raise NoCurveError(f"{model.keys[k]} = {value:.6g} cannot be changed by {step:.2g}")
        columns.append(sides[0] if len(sides) == 1 else _joined(*sides))
    return np.stack(columns, axis=1)


def _joined(ahead: np.ndarray, behind: np.ndarray) -> np.ndarray:
    middle = 0.5 * (ahead + behind)
    size = max(float(np.median(np.abs(middle))), 1e-300)
    jumps = np.abs(ahead - behind) > JUMP * np.maximum(size, np.abs(middle))
    smaller = np.where(np.abs(ahead) < np.abs(behind), ahead, behind)
    return np.asarray(np.where(jumps, smaller, middle))
