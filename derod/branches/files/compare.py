"""A push run held against branches: which branch each row lies on, and how far from it."""

from __future__ import annotations

from dataclasses import fields
from typing import TYPE_CHECKING, Any

import numpy as np

from derod.branches.files.record import BranchFile
from derod.branches.half_rod.center_line import center_line
from derod.branches.half_rod.outcome import NotConverged
from derod.branches.half_rod.parameters import Parameters
from derod.branches.half_rod.threads import one_blas_thread
from derod.branches.paths.landing import Landing, intervals, landings
from derod.errors import SceneError

if TYPE_CHECKING:
    from derod.branches.files.stored import StoredBranch

ON_BRANCH = 0.02
"""A row lies on a branch when t and E_hat (relative, or to 1) and shape (D) are this near to it."""
CANDIDATES = 4
SCREEN = 0.15
"""Sheets whose interpolated t and E_hat are further away than this (relative) are not looked at."""

ROW = np.dtype(
    [
        ("row", "i8"),
        ("end_shortening", "f8"),
        ("branch", "U16"),  # "" where the run sits on no branch
        ("tension_error", "f8"),  # relative to the branch's t, or to 1 where that is smaller
        ("energy_error", "f8"),  # of E_hat, likewise
        ("wetted_error", "f8"),  # D
        ("shape_error", "f8"),  # D
    ]
)
ERRORS = ("tension_error", "energy_error", "wetted_error", "shape_error")


def relative(value: float, reference: float) -> float:
    """|value - reference| in units of the reference, or of one where the reference is smaller."""
    return abs(value - reference) / max(1.0, abs(reference))


def shape_distance(a: np.ndarray, b: np.ndarray, *, turned: bool = True) -> float:
    """Largest distance of two centre lines (k, 3) after turning ``b`` about e_z, or its mirror
    image x -> -x.

    Branches of space curves come in mirror pairs of equal energy; a run may have picked either. With
    a weight (``turned`` false) the vertical is given, and nothing may be turned.
    """
    best = np.inf
    for mirror in (1.0, -1.0):
        x, y = b[:, 0] * mirror, b[:, 1]
        angle = np.angle(np.sum((a[:, 0] + 1j * a[:, 1]) * (x - 1j * y))) if turned else 0.0
        image = (x + 1j * y) * np.exp(1j * angle)
        gaps = np.stack([a[:, 0] - image.real, a[:, 1] - image.imag, a[:, 2] - b[:, 2]])
        best = min(best, float(np.sqrt((gaps**2).sum(axis=0)).max()))
    return best


def check_same_rod(run: Any, file: BranchFile) -> None:
    """Raise SceneError where the run's rod and drop are not those of the branches."""
    own = Parameters.from_scene(run.scene)
    for field in fields(Parameters):
        a, b = getattr(own, field.name), getattr(file.parameters, field.name)
        if not np.isclose(a, b, rtol=1e-12, atol=1e-14):
            raise SceneError(
                "of the run is not that of the branches",
                file=getattr(run.scene, "path", None),
                key=field.name,
                value=a,
                allowed=f"{b:g}, as in {file.path}",
            )


def estimate(branch: StoredBranch, i: int, delta: float) -> tuple[float, float]:
    """Tension and E_hat at ``delta`` between points i and i + 1, linearly."""
    a, b = branch.table[i], branch.table[i + 1]
    span = b["end_shortening"] - a["end_shortening"]
    x = float(np.clip((delta - a["end_shortening"]) / span, 0.0, 1.0)) if span else 0.5
    out = [(1.0 - x) * a[name] + x * b[name] for name in ("end_tension", "energy_hat")]
    return float(out[0]), float(out[1])


def _candidates(
    file: BranchFile, delta: float, tension: float, energy: float
) -> list[tuple[float, StoredBranch, int]]:
    """(distance, branch, index) of the sheets that pass near a row, nearest first."""
    out = []
    for branch in file.values():
        for i in intervals(branch, delta):
            t, e = estimate(branch, i, delta)
            distance = max(relative(tension, t), relative(energy, e))
            if distance < SCREEN:
                out.append((distance, branch, i))
    out.sort(key=lambda item: item[0])
    return out[:CANDIDATES]


def _errors(run: Any, i: int, row: np.void, landing: Landing) -> tuple[float, float, float, float]:
    values = landing.values
    curve = center_line(landing.state, run.arc_length(i))
    return (
        relative(float(row["end_tension"]), values["end_tension"]),
        relative(float(row["energy_hat"]), values["energy_hat"]),
        abs(float(row["wetted_length"]) - values["wetted_length"]),
        shape_distance(np.asarray(run.positions(i)), curve, turned=landing.state.weight == 0.0),
    )


@one_blas_thread
def compare(run: Any, file: BranchFile, every: int = 1) -> np.ndarray:
    """Compare the rows of a run with branches of the same rod: an array of ROW.

    ``run`` is what ``derod.open_run`` gives. Each row is held against the branch states at its own
    end-shortening (solved there, not interpolated); the nearest wins. Rows further than ON_BRANCH
    from every branch have branch "" and the errors to the nearest (nan if there is none). Raises
    SceneError where the run's parameters are not the branches'.
    """
    check_same_rod(run, file)
    picked = range(0, len(run), every)
    out = np.zeros(len(picked), ROW)
    for result, i in zip(out, picked, strict=True):
        row = run.table[i]
        delta = float(row["end_shortening"])
        result["row"], result["end_shortening"] = i, delta
        for name in ERRORS:
            result[name] = np.nan
        best = np.inf
        for _, branch, k in _candidates(
            file, delta, float(row["end_tension"]), float(row["energy_hat"])
        ):
            try:
                found = landings(branch, k, delta)
            except NotConverged:  # the row is held against the other sheets
                continue
            for landing in found:
                errors = _errors(run, i, row, landing)
                distance = max(errors[0], errors[1], errors[3])
                if distance < best:
                    best = distance
                    for name, value in zip(ERRORS, errors, strict=True):
                        result[name] = value
                    result["branch"] = branch.name if distance < ON_BRANCH else ""
            if best < 1e-3:
                break
    return out


def worst(result: np.ndarray) -> dict[str, tuple[float, float]]:
    """For each error its largest value over the rows on branches and the end-shortening there."""
    on = result[result["branch"] != ""]
    out = {}
    for name in ERRORS:
        if len(on):
            k = int(np.argmax(on[name]))
            out[name] = (float(on[name][k]), float(on["end_shortening"][k]))
        else:
            out[name] = (float("nan"), float("nan"))
    return out
