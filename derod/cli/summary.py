"""What a run did, in lines of text, for ``derod info``."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from derod.record import BaseRun, Run, layout
from derod.record.ending import ending_words
from derod.scene import Scene
from derod.scene.axis import AXES, END_SHORTENING, axes_of, both, with_units
from derod.scene.program import legs
from derod.scene.resolution import COARSE, edges_enough

EPS = float(np.finfo(np.float64).eps)
ROUNDING = 16.0  # of the stiffness h^-3 of a bent vertex, as in ``derod.rod.residual``
RANGES = (
    "end_tension",
    "energy_hat",
    "wetted_length",
    "holonomy",
    "wall_gap",
    "residual",
    "work_defect",
    "turning_angle",
)
LANDING_HEAD = (
    "  increment   delta, D   delta/pi          t      E_hat     wetted  unstable   residual"
)
SHOWN = ("end_shortening", "end_tension")
"""Controls that every line of the landings shows."""


def summary_lines(run: BaseRun) -> Iterator[str]:
    """The scene, the outcome, the landings, the events and the ranges of the rows of ``run``."""
    yield f"{run.path or 'a run in memory'}: {len(run)} increments, {outcome_line(run)}"
    if isinstance(run, Run):
        made = run.versions
        yield (
            f"  made {made['created']} with derod {made['derod']}, numpy {made['numpy']}, "
            f"numba {made['numba']}, h5py {made['h5py']}, Python {made['python']}"
        )
    yield from scene_lines(run.scene)
    if not len(run):
        return
    yield from landing_lines(run)
    yield from event_lines(run)
    yield from range_lines(run)
    yield from residual_lines(run)
    if run.ending is not None and run.ending.compiling >= 0.5:
        yield f"+ {run.ending.compiling:.0f} s compiling kernels, not counted in these"
    if run.extrapolated is not None:
        yield from error_lines(run)


def error_lines(run: BaseRun) -> Iterator[str]:
    """The largest estimated errors of an extrapolated run, relative."""
    rows = run.extrapolated
    assert rows is not None
    known = rows[np.isfinite(rows["end_tension"])]
    yield f"estimated errors, from half the edges ({len(known)} of {len(rows)} rows)"
    for name in ("end_tension", "energy_hat", "wetted_length") if len(known) else ():
        error = known[f"{name}_error"] / np.maximum(np.abs(known[name]), 1.0)
        worst = int(np.argmax(error))
        place = both(float(known["end_shortening"][worst]))
        yield f"  {name:15} {error[worst]:9.1e}  at {place}"


def outcome_line(run: BaseRun) -> str:
    """How the push ended, if it has."""
    return ending_words(run.ending)


def scene_lines(scene: Scene) -> Iterator[str]:
    """The scene in a few lines."""
    rod, drop, push = scene.rod, scene.drop, scene.push
    start = AXES[push.control]
    way = ", then ".join(
        f"{AXES[leg.control].name} to {AXES[leg.control].both(leg.stop)}" for leg in legs(scene)
    )
    yield f"  rod   l = {rod.length:g}, K = {rod.bending:g}, k3 = {rod.twisting:g}"
    if drop is None:
        yield "  no drop"
    else:
        yield (
            f"  drop  f_gamma = {drop.capillary_force:g}, v0 = {drop.wall_strength:g}, "
            f"rho = {drop.wall_softness:g}"
        )
    yield (
        f"  push  from {start.name} {start.both(push.start)}: {way}; end rotation at first "
        f"{scene.clamps.end_rotation:.6g} rad ({scene.clamps.end_rotation / math.pi:.6g} pi)"
    )
    yield (
        f"  with  {scene.mesh.edges} edges, {scene.relax.method} relaxation to "
        f"{scene.relax.tolerance:g}, seed {scene.noise.seed}, dimension {scene.model.dimension}"
    )


def landing_lines(run: BaseRun) -> Iterator[str]:
    """The increments that were asked for, and the last one."""
    table = run.table
    more = [axis for axis in axes_of(run.scene) if axis.column not in SHOWN]
    yield "landings (t in K0/D^2, E_hat in K0/D, wetted length in D, residual in K0/D^2)"
    yield LANDING_HEAD + "".join(f" {f'{axis.symbol}, {axis.unit}':>14}" for axis in more)
    wanted = table["landing"].copy()
    wanted[-1] = True
    for row in table[wanted]:
        value = float(row["end_shortening"])
        yield (
            f"  {row['increment']:9d} {value:10.5f} {value / math.pi:10.5f} "
            f"{row['end_tension']:10.5f} {row['energy_hat']:10.5f} {row['wetted_length']:10.5f} "
            f"{row['unstable_modes']:9d} {row['residual']:10.2e}"
            + "".join(f" {float(row[axis.column]):14.7g}" for axis in more)
        )


def event_lines(run: BaseRun) -> Iterator[str]:
    """What happened between the increments."""
    yield "events" if run.events else "events: none"
    for event in run.events:
        energies = (
            ""
            if math.isnan(event.energy_before) or math.isnan(event.energy_after)
            else f", E_hat {event.energy_before:.6g} -> {event.energy_after:.6g}"
        )
        message = with_units(event.message, event.end_shortening)
        yield (
            f"  before {event.increment:5d}  {both(event.end_shortening)}  "
            f"{event.kind}{energies}: {message}"
        )


def range_lines(run: BaseRun) -> Iterator[str]:
    """The range of the main fields, and whether the mesh is fine enough."""
    table = run.table
    yield "ranges"
    for axis in dict.fromkeys((END_SHORTENING, *axes_of(run.scene))):
        low, high = float(np.min(table[axis.column])), float(np.max(table[axis.column]))
        yield f"  {axis.column:16}{axis.both(low)} to {axis.both(high)}"
    for name in RANGES:
        if name not in [axis.column for axis in axes_of(run.scene)]:
            unit = layout.ROW_UNITS.get(name, "")
            yield f"  {name:16}{np.min(table[name]):12.6g} to {np.max(table[name]):.6g} {unit}"
    coarsest = table[np.argmax(table["turning_angle"])]
    if coarsest["turning_angle"] > COARSE:
        enough = edges_enough(run.scene.mesh.edges, float(coarsest["turning_angle"]))
        yield (
            "warning: the mesh is too coarse for the coil, which turns by "
            f"{coarsest['turning_angle']:.3g} rad at a node at "
            f"{both(float(coarsest['end_shortening']))}; {enough} edges would do"
        )


def residual_lines(run: BaseRun) -> Iterator[str]:
    """The worst residual, and what it is held to: the tolerance and what rounding leaves on the mesh."""
    table, scene = run.table, run.scene
    i = int(np.argmax(table["residual"]))
    worst = table[i]
    yield (
        f"worst residual {worst['residual']:.2e} K0/D^2 at increment {worst['increment']}, "
        f"{both(float(worst['end_shortening']))}"
    )
    edge = np.diff(run.arc_length(i))
    rounding = EPS * scene.rod.length * ROUNDING * scene.rod.bending
    wall = "" if scene.drop is None else ", and more beside a stiff wall"
    yield (
        f"  a node's is held to {scene.relax.tolerance * scene.rod.bending:.2g} (relax.tolerance) plus "
        f"what rounding leaves on the mesh, eps l 16 K/h^3:"
    )
    yield (
        f"  from {rounding / edge.max() ** 3:.1e} where edges are longest, h = {edge.max():.3g} D, to "
        f"{rounding / edge.min() ** 3:.1e} where they are shortest, h = {edge.min():.3g} D{wall}"
    )
    yield (
        f"{np.count_nonzero(~table['converged'])} rows not converged (residual above what it is held to), "
        f"{np.count_nonzero(table['unstable_modes'])} unstable, "
        f"{np.sum(table['iterations'])} iterations, {table['wall_time'][-1]:.2f} s"
    )
