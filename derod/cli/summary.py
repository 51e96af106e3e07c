"""What a run did, in lines of text, for ``derod info``."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from derod.record import BaseRun, Run
from derod.scene import Scene
from derod.scene.resolution import COARSE, edges_enough

RANGES = (
    "end_shortening",
    "end_tension",
    "energy_hat",
    "wetted_length",
    "holonomy",
    "wall_gap",
    "residual",
    "work_defect",
    "turning_angle",
)
LANDING_HEAD = "  increment   delta/pi          t      E_hat     wetted  unstable   residual"


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
    yield from landing_lines(run.table)
    yield from event_lines(run)
    yield from range_lines(run.table, run.scene.mesh.edges)
    if run.ending is not None and run.ending.compiling >= 0.5:
        yield f"+ {run.ending.compiling:.0f} s compiling kernels, not counted in these"
    if run.extrapolated is not None:
        yield from error_lines(run.extrapolated)


def error_lines(rows: np.ndarray) -> Iterator[str]:
    """The largest estimated errors of an extrapolated run, relative."""
    known = rows[np.isfinite(rows["end_tension"])]
    yield f"estimated errors, from half the edges ({len(known)} of {len(rows)} rows)"
    for name in ("end_tension", "energy_hat", "wetted_length") if len(known) else ():
        error = known[f"{name}_error"] / np.maximum(np.abs(known[name]), 1.0)
        worst = int(np.argmax(error))
        place = known["end_shortening"][worst] / math.pi
        yield f"  {name:15} {error[worst]:9.1e}  at {place:.4f} pi"


def outcome_line(run: BaseRun) -> str:
    """How the push ended, if it has."""
    if run.ending is None:
        return "not ended: it is still running, or was killed (derod push --resume goes on)"
    return f"{run.ending.outcome.replace('_', ' ')}: {run.ending.message}"


def scene_lines(scene: Scene) -> Iterator[str]:
    """The scene in a few lines."""
    rod, drop, push = scene.rod, scene.drop, scene.push
    stops = ", ".join(f"{stop / math.pi:.6g} pi" for stop in push.stop)
    yield f"  rod   l = {rod.length:g}, K = {rod.bending:g}, k3 = {rod.twisting:g}"
    if drop is None:
        yield "  no drop"
    else:
        yield (
            f"  drop  f_gamma = {drop.capillary_force:g}, v0 = {drop.wall_strength:g}, "
            f"rho = {drop.wall_softness:g}"
        )
    yield (
        f"  push  from {push.start / math.pi:.6g} pi to {stops}, end rotation "
        f"{scene.clamps.end_rotation / math.pi:g} pi"
    )
    yield (
        f"  with  {scene.mesh.edges} edges, {scene.relax.method} relaxation to "
        f"{scene.relax.tolerance:g}, seed {scene.noise.seed}, dimension {scene.model.dimension}"
    )


def landing_lines(table: np.ndarray) -> Iterator[str]:
    """The increments that were asked for, and the last one."""
    yield "landings"
    yield LANDING_HEAD
    wanted = table["landing"].copy()
    wanted[-1] = True
    for row in table[wanted]:
        yield (
            f"  {row['increment']:9d} {row['end_shortening'] / math.pi:10.5f} "
            f"{row['end_tension']:10.5f} {row['energy_hat']:10.5f} {row['wetted_length']:10.5f} "
            f"{row['unstable_modes']:9d} {row['residual']:10.2e}"
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
        yield (
            f"  before {event.increment:5d}  {event.end_shortening / math.pi:.5f} pi  "
            f"{event.kind}{energies}: {event.message}"
        )


def range_lines(table: np.ndarray, edges: int) -> Iterator[str]:
    """The range of the main fields, and the worst row."""
    yield "ranges"
    for name in RANGES:
        yield f"  {name:16}{np.min(table[name]):12.6g} to {np.max(table[name]):.6g}"
    coarsest = table[np.argmax(table["turning_angle"])]
    if coarsest["turning_angle"] > COARSE:
        yield (
            "warning: the mesh is too coarse for the coil, which turns by "
            f"{coarsest['turning_angle']:.3g} rad at a node at "
            f"{coarsest['end_shortening'] / math.pi:.5f} pi; "
            f"{edges_enough(edges, float(coarsest['turning_angle']))} edges would do"
        )
    worst = table[np.argmax(table["residual"])]
    yield (
        f"worst residual {worst['residual']:.2e} at increment {worst['increment']}, "
        f"{worst['end_shortening'] / math.pi:.5f} pi"
    )
    yield (
        f"{np.count_nonzero(~table['converged'])} rows not converged, "
        f"{np.count_nonzero(table['unstable_modes'])} unstable, "
        f"{np.sum(table['iterations'])} iterations, {table['wall_time'][-1]:.2f} s"
    )
