"""Compute the branches of a scene: trace the paths asked for, refine, count unstable modes."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable

from derod.branches.half_rod.outcome import NotConverged
from derod.branches.half_rod.parameters import Parameters
from derod.branches.half_rod.threads import one_blas_thread
from derod.branches.paths.arc import Control
from derod.branches.paths.branch import Branch
from derod.branches.paths.catalogue import UPSIDE_DOWN, Catalogue
from derod.branches.paths.path import Path, PathNotFound
from derod.branches.paths.special import SpuriousPoint
from derod.branches.paths.straight import NoBuckling

FAMILIES = ("Ax", "3D", "L", "Pt", "Tri")
"""First letters of the names: 3D is also 3D-L2, L all of L1, L2, ..., Tri all of Tri1, Tri2, ..."""
POINT_SYMMETRIC = "S"
"""The name of a point-symmetric planar path that a space path meets; one of the family Pt."""


def family(name: str) -> str:
    """The family of a path's name; raises ValueError for a name that no path has."""
    whole, name = name, name.removesuffix(UPSIDE_DOWN)
    if name and name.rstrip("'") == POINT_SYMMETRIC:
        return "Pt"
    for head in FAMILIES:
        tail = name[len(head) :]
        if name.startswith(head) and (
            not tail
            or (head in ("L", "Tri") and tail.rstrip("'").isdigit())
            or (head == "3D" and (tail.startswith("-L") or tail == "-K2"))
        ):
            return head
    raise ValueError(
        f"paths = {whole!r}: no such path; allowed: Ax, 3D, 3D-L1, ..., L1, L2, ..., Pt, Tri1, ..., "
        "3D, L, Tri for all of a kind, and with a heavy drop Ax-up, 3D-up, ..."
    )


def wanted(name: str, asked: Iterable[str]) -> bool:
    """Whether a traced path is among those asked for (a bare family name asks for all of it)."""
    return any(name == one or (one in FAMILIES and family(name) == one) for one in asked)


@one_blas_thread
def compute_branches(
    parameters: Parameters,
    paths: Iterable[str] | None = None,
    control: Control | None = None,
    count_modes: bool = True,
    progress: Callable[[str], None] = lambda line: None,
    keep: Callable[[Branch], None] = lambda branch: None,
    have: Collection[str] = (),
) -> tuple[list[Branch], list[str]]:
    """Trace the named paths of the paper (all of them by default).

    ``progress`` is called with one line a path, ``keep`` with each branch as it is done; branches
    that ``have`` names are traced, but not refined again. Returns the other branches in the order
    found and the complaints: names that were asked for and could not be found, with the reason.
    Raises ValueError for a name that no path can have.
    """
    asked = list(paths) if paths is not None else list(FAMILIES)
    families = {family(name) for name in asked}
    catalogues = [Catalogue(parameters, control)]
    if parameters.weight != 0.0:
        catalogues.append(Catalogue(parameters, control, upside_down=True))
    complaints: list[str] = []

    def report(path: Path) -> None:
        first, last = path.points[0].state, path.points[-1].state
        progress(
            f"{path.name:8s} delta {first.end_shortening:8.5f} .. {last.end_shortening:8.5f}  "
            f"{len(path.points):4d} points, {len(path.specials)} special  ends: {path.ends}"
        )
        for remark in path.remarks:
            progress(f"         {remark}")

    def trace(name: str, work: Callable[[], Iterable[Path]]) -> bool:
        try:
            for path in work():
                report(path)
        except (PathNotFound, NoBuckling, NotConverged, SpuriousPoint) as error:
            complaints.append(f"{name}: {error}")
            return False
        return True

    branches = []
    for catalogue in catalogues:
        _trace_all(catalogue, families, trace)
        complaints += catalogue.missed
        for name, path in catalogue.paths.items():
            if wanted(name, asked) and name not in have:
                branches.append(catalogue.store(path, count_modes))
                keep(branches[-1])
    if paths is not None:
        found = [*have, *(branch.name for branch in branches)]
        followed = ", ".join(name for catalogue in catalogues for name in catalogue.paths)
        complaints += [
            f"{one}: not met by the paths followed ({followed})"
            for one in asked
            if not any(wanted(name, [one]) for name in found)
        ]
    return branches, complaints


def _trace_all(
    catalogue: Catalogue,
    families: set[str],
    trace: Callable[[str, Callable[[], Iterable[Path]]], bool],
) -> None:
    """Trace the families of one catalogue; a point-symmetric curve carries no weight."""
    planar_start, ending = not catalogue.twisted, catalogue.ending
    sound = True
    if planar_start and families & {"Ax", "3D", "L", "Tri"}:
        sound = trace("Ax" + ending, lambda: [catalogue.ax()])
    if families & {"3D", "L"} and sound:
        trace("3D" + ending, catalogue.succession)
    if "3D" in families and planar_start and catalogue.parameters.anisotropic:
        trace("3D-K2" + ending, catalogue.stiff)
    if "Pt" in families and planar_start and catalogue.parameters.weight == 0.0:
        trace("Pt", lambda: [catalogue.pt()])
    if "Tri" in families and planar_start and "Ax" + ending in catalogue.paths:
        trace("Tri" + ending, catalogue.triangles)
