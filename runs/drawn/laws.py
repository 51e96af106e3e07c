"""Laws that the table of any damped, quasi-static push obeys; each returns the faults it finds."""

from __future__ import annotations

import numpy as np

from derod.record import BaseRun

FLOOR = 1e-6  # K0/D times the energies' size: differences that are none
JUMP = 0.6  # D a node may move in one increment without an event, and
PER_STEP = 2.5  # D for every D of end-shortening
STEEP = 2.0  # times the bound, for losses: beside a joint t peaks steeper than its differences
TURN = 2.5  # radians of holonomy in one increment without an event
LEAVES = ("instability", "snap")


def told(run: BaseRun) -> set[int]:
    """Return the increments before which an event tells of a jump."""
    return {event.increment for event in run.events if event.kind in LEAVES}


def rows_are_settled(run: BaseRun) -> list[str]:
    """Every row is a converged minimum inside the wall."""
    table, faults = run.table, []
    if not table["converged"].all():
        faults.append(f"{np.sum(~table['converged'])} rows not converged")
    if table["unstable_modes"].any():
        faults.append(f"{np.sum(table['unstable_modes'] > 0)} unstable rows")
    if not (table["wall_gap"] > 0).all():
        faults.append("a row outside the wall")
    return faults


def energy_is_the_sum(run: BaseRun) -> list[str]:
    """The parts of the energy add up, and E_hat is E_tot + f_gamma (delta + 1)."""
    table = run.table
    size = 1 + np.abs(table["energy_total"]).max()
    parts = sum(table[f"energy_{name}"] for name in ("bend", "twist", "wall", "capillary"))
    hat = table["energy_total"] + run.scene.drop.capillary_force * (table["end_shortening"] + 1)
    if np.abs(parts - table["energy_total"]).max() > 1e-12 * size:
        return ["the parts of the energy do not add up"]
    if np.abs(hat - table["energy_hat"]).max() > 1e-12 * size:
        return ["E_hat is not E_tot + f_gamma (delta + 1)"]
    return []


def defect_and_bound(table: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the energy gained over the work in each increment, and by how much the work may err, K0/D.

    The work is taken from t of the rows alone, by the trapezoid; it errs by no more than half the step
    squared times the steepest slope of t, there or in the neighbouring increments (a corner of t, at a
    pitchfork, lies within one).
    """
    delta, t, energy = (table[n] for n in ("end_shortening", "end_tension", "energy_total"))
    step = np.diff(delta)
    slope = np.abs(np.diff(t)) / np.maximum(np.abs(step), 1e-12)
    work = -0.5 * step * (t[1:] + t[:-1])
    near = np.maximum(slope, np.maximum(np.append(slope[1:], 0), np.append(0, slope[:-1])))
    near[-1:] *= 2  # the slope after the last row is not known
    bound = 0.5 * step**2 * near + FLOOR * (1 + np.abs(energy[1:]))
    return np.diff(energy) - work, bound


def energy_against_work(run: BaseRun) -> list[str]:
    """The energy never rises above the work of the end, and falls below it only with an event."""
    table, faults = run.table, []
    defect, bound = defect_and_bound(table)
    events = told(run)
    for i in range(len(defect)):
        if defect[i] > bound[i]:
            faults.append(
                f"gains {defect[i]:.3g} over the work (bound {bound[i]:.2g}) in row {i + 1}"
            )
        elif defect[i] < -STEEP * bound[i] and i + 1 not in events:
            faults.append(f"loses {-defect[i]:.3g} (bound {bound[i]:.2g}) silently in row {i + 1}")
    return faults


def nothing_jumps(run: BaseRun) -> list[str]:
    """Without an event, neither nodes nor the holonomy jump."""
    table, faults = run.table, []
    events = told(run)
    before = None
    for i in range(len(run)):
        here = run.positions(i)
        if before is not None and i not in events:
            step = abs(table["end_shortening"][i] - table["end_shortening"][i - 1])
            moved = float(np.linalg.norm(here - before, axis=1).max())
            if moved > JUMP + PER_STEP * step:
                faults.append(f"a node moves {moved:.3g} D silently in row {i}")
            turn = abs(table["holonomy"][i] - table["holonomy"][i - 1])
            if turn > TURN:
                faults.append(f"the holonomy jumps by {turn:.3g} silently in row {i}")
        before = here
    return faults


def the_ledger_is_right(run: BaseRun) -> list[str]:
    """``work_defect`` is what energy and work give, where the row before is of the same branch."""
    table = run.table
    own, error = defect_and_bound(table)
    off = np.abs(own - table["work_defect"][1:]) > STEEP * error
    off &= table["smooth"][1:]
    return [f"work_defect is wrong in {off.sum()} rows"] if off.any() else []


LAWS = (
    rows_are_settled,
    energy_is_the_sum,
    energy_against_work,
    nothing_jumps,
    the_ledger_is_right,
)


def audit(run: BaseRun) -> list[str]:
    """Return the faults of a run, by all laws."""
    return [fault for law in LAWS for fault in law(run)] if len(run) else ["no rows"]


def disagreements(run: BaseRun, finer: BaseRun, limit: float = 1e-3) -> list[str]:
    """Return where two pushes of one scene differ at common landings, relative to t, E_hat or 1."""
    faults = []
    for row in run.table[run.table["landing"]]:
        other = finer.table[finer.table["end_shortening"] == row["end_shortening"]]
        for name in ("end_tension", "energy_hat") if len(other) else ():
            off = abs(row[name] - other[0][name]) / max(1.0, abs(other[0][name]))
            if off > limit:
                faults.append(
                    f"{name} {row[name]:.6g} and {other[0][name]:.6g} at {row['end_shortening']:.5g}"
                )
    return faults


def side_was_open(run: BaseRun) -> bool:
    """Return whether an event says that a seed, and no symmetry, decided between different minima."""
    return any("of two minima" in event.message for event in run.events)
