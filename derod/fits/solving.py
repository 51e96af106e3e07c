"""Least squares on pushes: values, covariance, and what the data do not determine.

    minimise  sum_i (w_i (F_i - model_i(p)))^2        scipy.optimize.least_squares, method "trf"

in p over its starting values. With J the weighted Jacobian at the end, the covariance is (J^T J)^-1 where
errors were measured (w = 1/error), else s^2 (J^T J)^-1 with s^2 = (sum of squares)/(n - p). J is scaled to
columns of unit length; its singular values say what is determined (Bates and Watts, Nonlinear Regression
Analysis, 1988).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from derod.errors import SceneError
from derod.fits.data import Data
from derod.fits.model import Jacobian, Model, NoCurveError, differences
from derod.scene import Scene
from derod.scene.directors import check_pushable
from derod.sweeps.spreads import rule_of

LARGEST_CONDITION = 1e3
"""Of the scaled Jacobian: beyond it parameters can stand in for each other."""
RANK = 1e-7
"""Singular values below that share of the largest are those of the differences' own error."""
SURPRISE = 6.0
"""Standard deviations of chi^2 over its degrees of freedom, beyond which the model is told to be wrong."""
TOLERANCE = 1e-8
MOST_PUSHES = 2000


@dataclass(frozen=True)
class Fit:
    """The result of a fit."""

    keys: tuple[str, ...]
    values: np.ndarray
    """(p,), in the units of the scene's keys (SI for [material])."""
    errors: np.ndarray
    """(p,), standard uncertainties; inf of what is not determined."""
    covariance: np.ndarray
    """(p, p)."""
    converged: bool
    message: str
    chi_squared: float
    """The weighted sum of squares."""
    freedom: int
    """n - p."""
    condition: float
    """Of the scaled Jacobian."""
    warnings: tuple[str, ...]
    data: Data
    model: np.ndarray
    """(n,), the forces of the fitted scene."""
    pushes: int
    scene: Scene
    """The fitted scene."""
    start: Scene

    @property
    def residuals(self) -> np.ndarray:
        """(n,), measured force less model, times its weight."""
        return np.asarray(self.data.weight * (self.data.force - self.model))

    def __repr__(self) -> str:
        told = ", ".join(
            f"{key} = {value:.6g} +- {error:.2g}"
            for key, value, error in zip(self.keys, self.values, self.errors, strict=True)
        )
        return f"<fit: {told}; {'converged' if self.converged else 'NOT CONVERGED'}>"


def fit(
    data: Data,
    scene: Scene,
    free: Sequence[str],
    *,
    jacobian: Jacobian = differences,
    watch: Callable[[int, float], None] = lambda pushes, cost: None,
) -> Fit:
    """Fit the ``free`` keys of a scene, from their values in it, to measured data.

    ``jacobian(model, values)`` gives d force/d value (n, p); ``watch`` hears of pushes done and the sum of
    squares. Raises SceneError for keys and data that cannot be fitted, NoCurveError where the scene itself
    cannot be pushed to the end of the data.
    """
    from scipy.optimize import least_squares

    begin = starting_values(scene, free)
    check_data(data, scene, free)
    check_pushable(scene)
    model = Model(scene, tuple(free), data)
    model(begin)  # raises here what is wrong with the scene itself
    scale = np.where(begin == 0.0, 1.0, begin)
    size = math.sqrt(float(np.mean((data.weight * data.force) ** 2))) or 1.0
    weight = data.weight / size  # newtons are small numbers: tolerances are relative to the data

    def residuals(q: np.ndarray) -> np.ndarray:
        try:
            found = weight * (model(q * scale) - data.force)
        except (SceneError, NoCurveError):
            return np.full(len(data), np.inf)  # "trf" takes a shorter step
        watch(model.pushes, size**2 * float(found @ found))
        return np.asarray(found)

    def slopes(q: np.ndarray) -> np.ndarray:
        return np.asarray(weight[:, None] * jacobian(model, q * scale) * scale)

    found = least_squares(
        residuals, begin / scale, slopes, method="trf", x_scale="jac", xtol=TOLERANCE,
        ftol=TOLERANCE, gtol=1e-14, max_nfev=MOST_PUSHES // (2 * len(begin) + 1),
    )  # fmt: skip
    values = found.x * scale
    covariance, condition, warnings = determined(size * found.jac / scale, free, values)
    squares = 2.0 * size**2 * float(found.cost)
    freedom = len(data) - len(begin)
    if not data.has_errors:
        known = np.isfinite(covariance)
        covariance[known] *= squares / freedom
    errors = np.sqrt(np.maximum(np.diag(covariance), 0.0))
    for key, value, error in zip(free, values, errors, strict=True):
        if math.isfinite(error) and error > abs(value):
            warnings.append(f"{key} = {value:.3g} +- {error:.2g}: the data hardly determine it")
    if data.has_errors and squares / freedom > 1.0 + SURPRISE * math.sqrt(2.0 / freedom):
        warnings.append(
            f"the scene does not give the data within their errors: sum of squares over degrees of "
            f"freedom {squares / freedom:.3g}, not 1"
        )
    return Fit(
        tuple(free), values, errors, covariance, found.status > 0, str(found.message), squares,
        freedom, condition, tuple(warnings), data, model(values), model.pushes,
        model.scene_at(values), scene,
    )  # fmt: skip


def determined(
    jacobian: np.ndarray, keys: Sequence[str], values: np.ndarray
) -> tuple[np.ndarray, float, list[str]]:
    """(J^T J)^-1, the condition number of J with columns of unit length, and what is to be warned of.

    Directions that the data do not determine have infinite variance; so have the parameters in them.
    """
    warnings: list[str] = []
    size = np.linalg.norm(jacobian, axis=0)
    relative = size * np.where(values == 0.0, 1.0, np.abs(values))
    silent = relative <= RANK * max(float(relative.max()), 1e-300)
    warnings += [
        f"{keys[k]} does not change the data: it is not determined"
        for k in np.flatnonzero(silent).tolist()
    ]
    count = len(keys)
    covariance = np.zeros((count, count))
    covariance[silent, silent] = np.inf
    active = np.flatnonzero(~silent)
    if not active.size:
        return covariance, math.inf, warnings
    _, singular, rows = np.linalg.svd(jacobian[:, active] / size[active], full_matrices=False)
    condition = math.inf if silent.any() else float(singular[0] / max(singular[-1], 1e-300))
    weak = singular < RANK * singular[0]
    inverse = (rows[~weak].T / singular[~weak] ** 2) @ rows[~weak]
    covariance[np.ix_(active, active)] = inverse / np.outer(size[active], size[active])
    for row in rows[weak]:
        covariance[active[np.abs(row) > 0.1], active[np.abs(row) > 0.1]] = np.inf
    if singular[-1] * LARGEST_CONDITION < singular[0]:
        names = [keys[active[k]] for k in np.flatnonzero(np.abs(rows[-1]) > 0.1)]
        ratio = singular[0] / max(singular[-1], 1e-300)
        warnings.append(
            f"{' and '.join(names)} can stand in for each other: the data do not determine them "
            f"singly (condition number {ratio:.1e})"
        )
    return covariance, condition, warnings


def starting_values(scene: Scene, free: Sequence[str]) -> np.ndarray:
    """The values (p,) of the free keys in the scene. Raises SceneError for what cannot be free."""
    if not free:
        raise SceneError("is empty: nothing is to be fitted", file=scene.path, key="free",
                         allowed="keys such as drop.capillary_force, rod.bending")  # fmt: skip
    values = []
    for k, key in enumerate(free):
        rule_of(key, scene.path)
        if key in free[:k]:
            raise SceneError("is free twice", file=scene.path, key=key)
        table, _, name = key.partition(".")
        if table not in ("rod", "drop", "clamps", "material") or name == "end_shortening":
            raise SceneError("cannot be fitted", file=scene.path, key=key,
                             allowed="keys of [rod], [drop], [clamps] and [material]")  # fmt: skip
        value = getattr(getattr(scene, table), name, None)
        value = getattr(value, "value", value)
        if not isinstance(value, float):
            raise SceneError("is not in the scene, or no number", file=scene.path, key=key)
        scene.replace({key: value})  # says what gives it where [material] does
        values.append(value)
    return np.array(values)


def check_data(data: Data, scene: Scene, free: Sequence[str]) -> None:
    """Raise SceneError where the data and the scene do not fit together."""
    if len(data) <= len(free):
        raise SceneError(f"has {len(data)} rows that count, for {len(free)} free values",
                         file=data.path, allowed="more rows than free values")  # fmt: skip
    if scene.push.control != "end_shortening" or scene.steps:
        raise SceneError("pushes with another control than the end-shortening", file=scene.path,
                         key="push.control", value=scene.push.control,
                         allowed="end_shortening, without [[steps]]")  # fmt: skip
    if data.si and scene.material is None:
        raise SceneError("is missing: the data are in SI", file=scene.path, key="material",
                         allowed="a scene with [material], or data in D and K0/D^2")  # fmt: skip
