"""What a hard push must show beside its ending: (what, value, limit), in order when value <= limit."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from bench.branches import branches_of

import derod
from derod.branches.files.compare import compare
from derod.branches.files.record import open_branches
from derod.branches.half_rod.mirror import STRAIGHT_LOOP
from derod.branches.half_rod.parameters import Parameters
from derod.branches.paths.straight import buckling_tensions
from derod.record import BaseRun

Check = tuple[str, float, float]


def hard_wall(run: BaseRun) -> Check:
    """A planar loop of curvature 2/(1+rho) that costs 2/(1+rho)^2 of what wetting gains."""
    drop = run.scene.drop
    limit = drop.capillary_force - 2 / (1 + drop.wall_softness) ** 2
    return "t off f - 2/(1+rho)^2", abs(run.table["end_tension"][-1] - limit), 0.1


def buckling(run: BaseRun) -> Check:
    """The first state's tension against linear stability of the straight rod."""
    exact = buckling_tensions(Parameters.from_scene(run.scene), STRAIGHT_LOOP)[0]
    value = abs(run.table["end_tension"][0] - exact) / max(1.0, abs(exact))
    return "t of buckling, relative", value, 0.01


def on_ax(run: BaseRun) -> Check:
    """The tension against branch Ax of the boundary-value problem, where that has begun."""
    with open_branches(branches_of("paper-figures")) as branches:
        result = compare(run, branches)
    found = result[result["branch"] == "Ax"]
    assert len(found) > 0.7 * len(run), "the rows do not lie on Ax"
    return "error of t on Ax", float(found["tension_error"].max()), 1e-5


def snap(run: BaseRun) -> Check:
    """A snap past the fold of planar Ax, at 1.3312 pi; it loses energy, and so does any other."""
    snaps = [e for e in run.events if e.kind == "snap"]
    right = bool(snaps) and all(e.energy_after < e.energy_before for e in snaps)
    value = abs(snaps[0].end_shortening / np.pi - 1.3312) if right else np.inf
    return "snap off 1.3312 pi, pi", value, 0.01


def same_places(run: BaseRun, first: int, second: int) -> tuple[np.ndarray, np.ndarray]:
    """Return the rows of two legs at the same end-shortenings."""
    table = run.table
    rows = [np.flatnonzero(table["segment"] == leg) for leg in (first, second)]
    _, a, b = np.intersect1d(
        table["end_shortening"][rows[0]], table["end_shortening"][rows[1]], return_indices=True
    )
    return table[rows[0][a]], table[rows[1][b]]


def loop(run: BaseRun) -> Check:
    """First and third leg where they land on the same end-shortening: their last rows."""
    table = run.table
    first = table[table["segment"] == 0][-1]
    third = table[table["segment"] == 2][-1]
    return (
        "t, E of both legs",
        max(abs(first[name] - third[name]) for name in ("end_tension", "energy_hat")),
        1e-7,
    )


def unloaded(run: BaseRun) -> Check:
    """The state at 0.2 pi on the way in and on the way out."""
    on_the_way_in, back = same_places(run, 0, 1)
    assert back["end_shortening"].size, "no landing in common"
    return (
        "t in and out",
        float(np.abs(on_the_way_in["end_tension"] - back["end_tension"]).max()),
        1e-7,
    )


def planar(run: BaseRun) -> Check:
    """The largest coordinate out of the plane, over all rows."""
    return (
        "out of plane, D",
        max(float(np.abs(run.positions(i)[:, 0]).max()) for i in range(len(run))),
        0.0,
    )


def no_drift(run: BaseRun) -> Check:
    """Where the nodes are at the first and at the last return to the start."""
    delta = run.table["end_shortening"]
    places = np.flatnonzero(delta == delta[0])
    moved = run.positions(int(places[-1])) - run.positions(int(places[0]))
    return f"moved in {len(run)} rows, D", float(np.abs(moved).max()), 1e-6


def pushed_like(run: BaseRun, changes: dict) -> np.void:
    """Return the last row of an easier push to the same place."""
    stop = float(run.table["end_shortening"][-1])
    return derod.push(run.scene.replace({"push.stop": stop, **changes})).table[-1]


def as_small_steps(run: BaseRun) -> Check:
    """The same state as an ordinary push reaches."""
    easy = pushed_like(run, {"push.start": "0.001 pi", "push.max_step": "0.02 pi"})
    last = run.table[-1]
    return (
        "t, E of small steps",
        max(abs(last[name] - easy[name]) for name in ("end_tension", "energy_hat")),
        1e-6,
    )


def as_quarter_steps(run: BaseRun) -> Check:
    """The same state as a push in steps of a quarter."""
    easy = pushed_like(run, {"push.max_step": run.scene.push.max_step / 4})
    last = run.table[-1]
    return (
        "t, E of quarter steps",
        max(abs(last[name] - easy[name]) for name in ("end_tension", "energy_hat")),
        1e-6,
    )


def as_fine(run: BaseRun, limit: float = 1e-6) -> Check:
    """The same tension as at 800 edges."""
    last, easy = run.table[-1], pushed_like(run, {"mesh.edges": 800})
    return "t of 800 edges, relative", abs(last["end_tension"] / easy["end_tension"] - 1), limit


def as_fine_on_wall(run: BaseRun) -> Check:
    """The same, where a hard wall is touched at single nodes."""
    return as_fine(run, 1e-4)


def wetted_thirty(run: BaseRun) -> Check:
    """How much of 30 D is missing inside."""
    return "30 - wetted length, D", 30 - float(run.table["wetted_length"][-1]), 0.3


CHECKS: dict[str, Callable[[BaseRun], Check]] = {
    "hard wall": hard_wall,
    "buckling": buckling,
    "on Ax": on_ax,
    "snap": snap,
    "loop": loop,
    "unloaded": unloaded,
    "planar": planar,
    "no drift": no_drift,
    "as from small steps": as_small_steps,
    "as a quarter of the step": as_quarter_steps,
    "as fine": as_fine,
    "as fine, on a wall": as_fine_on_wall,
    "wetted 30": wetted_thirty,
}
