"""Laws that the table of any damped, quasi-static push obeys; each returns the faults it finds."""

from __future__ import annotations

from collections.abc import Callable

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
    parts = sum(
        table[f"energy_{name}"] for name in ("bend", "twist", "wall", "capillary", "weight")
    )
    hat = table["energy_total"] + table["capillary_force"] * (table["end_shortening"] + 1)
    if np.abs(parts - table["energy_total"]).max() > 1e-12 * size:
        return ["the parts of the energy do not add up"]
    if np.abs(hat - table["energy_hat"]).max() > 1e-12 * size:
        return ["E_hat is not E_tot + f_gamma (delta + 1)"]
    return []


CONJUGATES: dict[str, Callable[[np.ndarray], np.ndarray]] = {
    "end_shortening": lambda table: -table["end_tension"],
    "end_rotation": lambda table: table["twisting_moment"],
    "capillary_force": lambda table: -table["wetted_length"],
    "wall_strength": lambda table: table["energy_wall"] / table["wall_strength"],
    "weight": lambda table: table["drop_height"],
}


def controls_of(run: BaseRun) -> list[str]:
    """Return what pushed to each row."""
    names = [run.scene.push.control] * len(run.scene.push.stop)
    for step in run.scene.steps:
        names += [step.control] * len(step.stop)
    return [names[segment] for segment in run.table["segment"]]


def defect_and_bound(run: BaseRun) -> tuple[np.ndarray, np.ndarray]:
    """Return the energy gained over the work in each increment, and by how much the work may err, K0/D.

    The work is taken from the rows' conjugates alone, by the trapezoid; it errs by no more than half the step
    squared times the steepest slope, there or in the neighbouring increments (a corner, at a pitchfork, lies
    within one).
    """
    table, controls = run.table, controls_of(run)
    energy = table["energy_total"]
    step, work, slope = (np.zeros(max(len(table) - 1, 0)) for _ in range(3))
    for i in range(len(step)):
        name = controls[i + 1]
        rows = table[i : i + 2]
        c = CONJUGATES[name](rows)
        step[i] = rows[name][1] - rows[name][0]
        work[i] = 0.5 * step[i] * (c[0] + c[1])
        slope[i] = abs(c[1] - c[0]) / max(abs(step[i]), 1e-12)
    near = np.maximum(slope, np.maximum(np.append(slope[1:], 0), np.append(0, slope[:-1])))
    near[-1:] *= 2  # the slope after the last row is not known
    bound = 0.5 * step**2 * near + FLOOR * (1 + np.abs(energy[1:]))
    return np.diff(energy) - work, bound


def energy_against_work(run: BaseRun) -> list[str]:
    """The energy never rises above the work of the end, and falls below it only with an event."""
    faults = []
    defect, bound = defect_and_bound(run)
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
            if table["segment"][i] > 0 and run.scene.steps:
                step = 0.02 * np.pi  # other controls' usual steps move the rod about as far
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
    own, error = defect_and_bound(run)
    off = np.abs(own - table["work_defect"][1:]) > STEEP * error
    off &= table["smooth"][1:]
    return [f"work_defect is wrong in {off.sum()} rows"] if off.any() else []


def clamps_hold_the_weight(run: BaseRun) -> list[str]:
    """Forces at the clamps balance the drop's weight in every row."""
    table = run.table
    size = 1 + np.abs(table["end_tension"]).max()
    off = [
        table[f"end_force_{k}"] - table[f"start_force_{k}"] - (k == "y") * table["weight"]
        for k in "xyz"
    ]
    worst = float(np.abs(off).max())
    return [f"forces are off balance by {worst:.2g}"] if worst > 1e-7 * size else []


LAWS = (
    rows_are_settled,
    energy_is_the_sum,
    energy_against_work,
    nothing_jumps,
    the_ledger_is_right,
    clamps_hold_the_weight,
)


def audit(run: BaseRun) -> list[str]:
    """Return the faults of a run, by all laws."""
    return [fault for law in LAWS for fault in law(run)] if len(run) else ["no rows"]


def disagreements(run: BaseRun, finer: BaseRun, limit: float = 1e-3) -> list[str]:
    """Return where two pushes of one scene differ at common landings, relative to t, E_hat or 1."""
    faults = []
    for row in run.table[run.table["landing"]]:
        control = controls_of(run)[int(row["increment"])]
        same = finer.table["segment"] == row["segment"]
        other = finer.table[same & (finer.table[control] == row[control])]
        for name in ("end_tension", "energy_hat") if len(other) else ():
            off = abs(row[name] - other[0][name]) / max(1.0, abs(other[0][name]))
            if off > limit:
                faults.append(
                    f"{name} {row[name]:.6g} and {other[0][name]:.6g} at {row['end_shortening']:.5g}"
                )
    return faults


def side_was_open(run: BaseRun) -> bool:
    """Return whether an event says that a seed decided between minima that go on differently.

    Mirror images do where the end is turned afterwards: one is wound up by it, the other unwound.
    """
    words = ["of two minima"]
    if any(step.control == "end_rotation" for step in run.scene.steps):
        words.append("the side is the seed's")
    return any(word in event.message for event in run.events for word in words)
