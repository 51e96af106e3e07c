"""The result of a fit as files: TOML or JSON, a table, and the fitted scene."""

from __future__ import annotations

import json
import math
from typing import Any

from derod.fits.solving import Fit

UNITS = {True: ("m", "N"), False: ("D", "K0 D-2")}


def as_data(fit: Fit) -> dict[str, Any]:
    """The result as plain tables. What is infinite is "not determined"."""
    return {
        "outcome": "converged" if fit.converged else "not_converged",
        "message": fit.message,
        "warnings": list(fit.warnings),
        "data": {
            "file": fit.data.path or "",
            "rows": len(fit.data),
            "gaps": fit.data.gaps,
            "units": list(UNITS[fit.data.si]),
            "errors": "measured" if fit.data.has_errors else "from what the fit leaves over",
        },
        "statistics": {
            "sum_of_squares": fit.chi_squared,
            "degrees_of_freedom": fit.freedom,
            "reduced": fit.chi_squared / fit.freedom,
            "condition_number": _finite(fit.condition),
            "pushes": fit.pushes,
        },
        "values": dict(zip(fit.keys, map(float, fit.values), strict=True)),
        "errors": dict(zip(fit.keys, map(_finite, fit.errors), strict=True)),
        "covariance": [[_finite(x) for x in row] for row in fit.covariance],
    }


def as_json(fit: Fit) -> str:
    """The result as JSON."""
    return json.dumps(as_data(fit), indent=1) + "\n"


def as_toml(fit: Fit) -> str:
    """The result as TOML."""
    data = as_data(fit)
    plain = {key: value for key, value in data.items() if not isinstance(value, dict)}
    lines = [f"{key} = {_toml(value)}" for key, value in plain.items()]
    for table, values in data.items():
        if isinstance(values, dict):
            lines += ["", f"[{table}]"]
            lines += [f"{json.dumps(key)} = {_toml(value)}" for key, value in values.items()]
    return "\n".join(lines) + "\n"


def as_table(fit: Fit) -> str:
    """Data, model and residuals as CSV, in SI or in D and K0/D^2."""
    length, force = UNITS[fit.data.si]
    lines = [f"displacement [{length}],force [{force}],model [{force}],weighted residual"]
    columns = (fit.data.displacement, fit.data.force, fit.model, fit.residuals)
    lines += [",".join(repr(float(x)) for x in row) for row in zip(*columns, strict=True)]
    return "\n".join(lines) + "\n"


def told(fit: Fit) -> list[str]:
    """The result in lines for a terminal."""
    width = max(len(key) for key in fit.keys)
    lines = []
    for key, value, error in zip(fit.keys, fit.values, fit.errors, strict=True):
        size = "not determined" if math.isinf(error) else f"+- {error:.2g}"
        lines.append(f"  {key:{width}}  {value:.6g} {size}")
    reduced = fit.chi_squared / fit.freedom
    lines.append(
        f"  {len(fit.data)} rows, {fit.data.gaps} gaps; sum of squares over {fit.freedom} degrees "
        f"of freedom {reduced:.3g}; condition number {fit.condition:.3g}; {fit.pushes} pushes"
    )
    return lines


def _finite(value: float) -> float | str:
    return float(value) if math.isfinite(value) else "not determined"


def _toml(value: Any) -> str:
    if isinstance(value, list):
        return "[" + ", ".join(_toml(item) for item in value) + "]"
    return json.dumps(value) if isinstance(value, str) else repr(value)
