"""Which pictures there are, what each needs, and whether the files given are those."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from derod.exits import UsageError
from derod.needs import need
from derod.scene.axis import both
from derod.scene.quantities import read_quantity


@dataclass(frozen=True)
class Kind:
    """A picture: the module that draws it, what it shows, and which files it is made of.

    ``runs`` and ``branches`` are the least and the largest number of files of each sort.
    """

    module: str
    shows: str
    runs: tuple[int, float]
    branches: tuple[int, float]
    wants: str
    sweeps: tuple[int, float] = (0, 0)


KINDS = {
    "path": Kind(
        "derod.views.plots.path", "t and E_hat against delta: stability, events, bifurcations",
        (0, math.inf), (0, math.inf), "run files and branch files",
    ),
    "shapes": Kind(
        "derod.views.plots.shapes", "the rod and its drop at given end-shortenings",
        (0, math.inf), (0, math.inf), "run files and branch files",
    ),
    "energies": Kind(
        "derod.views.plots.energies", "the parts of the energy along a push", (1, 1), (0, 0), "one run file",
    ),
    "kymograph": Kind(
        "derod.views.plots.kymograph", "curvature and tension along the rod against delta",
        (1, 1), (0, 0), "one run file",
    ),
    "modes": Kind(
        "derod.views.plots.modes", "the softest modes at given end-shortenings",
        (1, 1), (0, 0), "one run file",
    ),
    "eigenvalues": Kind(
        "derod.views.plots.eigenvalues", "the lowest eigenvalues against delta",
        (1, 1), (0, 0), "one run file",
    ),
    "compare": Kind(
        "derod.views.plots.compare", "errors of a push, held against the branches",
        (1, math.inf), (1, 1), "run files and one branch file",
    ),
    "phase": Kind(
        "derod.views.plots.phase", "state, coils and tension over two keys of a sweep",
        (0, 0), (0, math.inf), "one sweep, and branch files", (1, 1),
    ),
    "bands": Kind(
        "derod.views.plots.bands", "t against delta with the bands of uncertain values",
        (0, 0), (0, 0), "one sweep of samples or differences", (1, 1),
    ),
}  # fmt: skip
"""Every kind of picture by its name."""


@dataclass(frozen=True)
class Options:
    """What a picture may be told: end-shortenings (D), names of branches, every n-th increment, modes."""

    at: tuple[float, ...] = ()
    paths: tuple[str, ...] = ()
    every: int = 1
    modes: int = 3
    keys: tuple[str, ...] = ()


def read_places(at: Sequence[str | float] | str, key: str = "at") -> tuple[float, ...]:
    """End-shortenings (D) from numbers, from texts such as "0.5 pi", or from "0.5 pi, 1 pi".

    Raises UsageError, which calls them ``key``.
    """
    parts: Sequence[Any] = at.split(",") if isinstance(at, str) else at
    out = []
    for part in parts:
        try:
            out.append(read_quantity(part))
        except ValueError as error:
            raise UsageError(
                f"{key} = {part!r}: {error}; allowed: end-shortenings (D) such as 0.5 pi or 1.2, "
                "separated by commas"
            ) from None
    return tuple(out)


def written(delta: float) -> str:
    """An end-shortening in both of its units."""
    return both(delta)


def file_name(file: Any) -> str:
    """What messages call a run or a branch file."""
    return str(file.path) if file.path else "a run in memory"


def need_matplotlib() -> None:
    """Raise MissingError, naming the package, where matplotlib is not installed."""
    need("matplotlib", "a picture")


def check_files(
    kind: str,
    runs: Sequence[Any],
    branches: Sequence[Any],
    options: Options,
    sweeps: Sequence[Any] = (),
) -> None:
    """Raise UsageError where the files cannot give this kind of picture, or have no such state."""
    wanted = KINDS[kind]
    sorts = (
        (runs, wanted.runs, "a run file", "derod push"),
        (branches, wanted.branches, "a branch file", "derod branch"),
        (sweeps, wanted.sweeps, "a sweep", "derod sweep"),
    )
    for files, (_, most), sort, _ in sorts:
        if len(files) > most:
            raise UsageError(
                f"{file_name(files[int(most)])}: is {sort}{' too many' if most else ''}; "
                f"allowed for {kind}: {wanted.wants}"
            )
    for files, (least, _), sort, command in sorts:
        if len(files) < least:
            raise UsageError(f"{kind}: {sort} ({command}) is missing; allowed: {wanted.wants}")
    if options.keys and not sweeps:
        raise UsageError(f"keys = {', '.join(options.keys)}: names keys, and no sweep is given")
    if not runs and not branches and not sweeps:
        raise UsageError(f"{kind}: a file is missing; allowed: {wanted.wants}")
    for run in runs:
        if not len(run):
            raise UsageError(f"{file_name(run)}: has no increment to draw")
    if options.paths and not branches:
        raise UsageError(
            f"paths = {', '.join(options.paths)}: names branches, and no branch file is given"
        )
    for file in branches:
        for name in options.paths:
            if name not in file:
                raise UsageError(
                    f"{file_name(file)}: paths = {name}: is not in it; "
                    f"allowed: {', '.join(file.keys())}"
                )
    _check_places(runs, branches, options)


def _check_places(runs: Sequence[Any], branches: Sequence[Any], options: Options) -> None:
    tables = [(file_name(run), run.table) for run in runs]
    tables += [
        (f"{file_name(file)}: {name}", branch.table)
        for file in branches
        for name, branch in file.items()
        if not options.paths or name in options.paths
    ]
    spans = [
        (name, float(table["end_shortening"].min()), float(table["end_shortening"].max()))
        for name, table in tables
    ]
    for delta in options.at:
        if not any(low - 1e-9 <= delta <= high + 1e-9 for _, low, high in spans):
            low, high = min(span[1] for span in spans), max(span[2] for span in spans)
            raise UsageError(
                f"{spans[0][0]}: at = {written(delta)}: has no state there; "
                f"allowed: {written(low)} to {written(high)}"
            )
