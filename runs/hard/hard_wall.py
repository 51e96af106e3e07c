"""Pt against a harder and harder wall: its tension must near f_gamma - 2, the limit of a hard drop.

The push does not get there by itself (Pt is unstable in space). A state of the boundary-value problem is put
on the rod's mesh, relaxed in its plane, and the wall is made thin first (rho), then hard (v0).
"""

from __future__ import annotations

import numpy as np
from bench.branches import RUNS, branches_of
from hard.checks import Check
from scipy.interpolate import CubicSpline

import derod
from derod.branches.files.record import open_branches
from derod.equilibrium.loop import relax
from derod.equilibrium.measured import measure
from derod.equilibrium.methods import make_relaxer
from derod.equilibrium.system import System
from derod.pushing.controls import CONTROLS
from derod.rod.state import State
from derod.rod.unknowns import S_A, S_B, X_C

PLACE = 1.5 * np.pi  # on the plateau of Pt
SOFTNESS = (0.1, 0.005)
STRENGTH = (2e-4, 1e-9)
THINNER, HARDER = 0.9, 0.3  # from one wall to the next


def planar_system(strength: float, softness: float) -> System:
    """Return the paper's rod in its plane, against another wall."""
    changes = {"drop.wall_strength": strength, "drop.wall_softness": softness}
    scene = derod.load_scene(RUNS / "paper-text.toml")
    return System(scene.replace({"push.at": [], "model.dimension": 2, **changes}))


def state_of_pt(system: System) -> State:
    """Return the branch's state nearest to ``PLACE`` on the system's mesh."""
    with open_branches(branches_of("paper-text", "Pt")) as branches:
        branch = branches["Pt"]
        i = int(np.argmin(np.abs(branch.table["end_shortening"] - PLACE)))
        row, places, s = branch.table[i], branch.positions(i), branch.arc_length(i)
        centre = branch.drop_center(i)
    state = State(
        np.zeros((system.edges + 1, 3)),
        np.zeros(7),
        0.0,
        float(row["end_shortening"]),
        system.physics,
    )
    length, capillary = system.physics.length, system.physics.capillary_force
    state.b[S_A] = 0.5 * (length - row["wetted_length"])
    state.b[S_B] = length - state.b[S_A]
    lateral = int(np.argmax(np.abs(places[:, :2]).max(axis=0)))
    plane = [lateral, 2]
    state.q[:, :2] = CubicSpline(s, places[:, plane])(system.arc_length(state))
    state.q[0, :2] = 0.0
    state.clamp_at(state.end_shortening)
    kin = system.room.kin
    state.q[1:, 2] = row["end_tension"]
    state.q[1 + kin.node_a : 1 + kin.node_b, 2] -= capillary
    state.b[X_C : X_C + 2] = centre[plane]
    state.b[X_C + 2 : X_C + 4] = 0.5 * row["meniscus_force"]
    return state


def squeezed(system: System, state: State, softness: float) -> State:
    """Return the state with what lies in the wall's layer moved into a thinner one."""
    kin, moved = system.room.kin, state.copy()
    wetted = slice(kin.node_a, kin.node_b + 1)
    arm = moved.q[wetted, :2] - moved.b[X_C : X_C + 2]
    r = np.linalg.norm(arm, axis=1)
    thinner = 0.5 + (r - 0.5) * softness / system.physics.wall_softness
    moved.q[wetted, :2] += arm * np.where(r > 0.5, thinner / np.maximum(r, 0.5) - 1, 0.0)[:, None]
    return moved


def harder_walls() -> list[tuple[float, float]]:
    """Return the walls on the way: (strength, softness), first thinner, then harder."""
    walls = [(STRENGTH[0], SOFTNESS[0])]
    while walls[-1][1] > SOFTNESS[1]:
        walls.append((STRENGTH[0], max(THINNER * walls[-1][1], SOFTNESS[1])))
    while walls[-1][0] > STRENGTH[1]:
        walls.append((max(HARDER * walls[-1][0], STRENGTH[1]), SOFTNESS[1]))
    return walls


def pt_at_a_hard_wall() -> tuple[str, str, Check, str]:
    """The tension of Pt on its plateau, at the hardest wall."""
    system = planar_system(*harder_walls()[0])
    state = state_of_pt(system)
    iterations, unstable = 0, 0
    for strength, softness in harder_walls():
        thin = squeezed(system, state, softness)
        system = planar_system(strength, softness)
        thin.physics = system.physics
        solution = relax(make_relaxer("implicit"), system, thin)
        iterations += solution.iterations
        if not solution.converged:
            check = ("v0 reached", strength, STRENGTH[1])
            return "converged", str(solution.outcome), check, solution.message[:90]
        state = solution.state
        unstable = max(unstable, measure(system, state, CONTROLS["end_shortening"]).unstable_modes)
    system.gradient(state)
    limit = system.physics.capillary_force - 2
    check = ("t off f_gamma - 2", abs(system.end_tension(state) - limit), 0.05)
    gap = system.wall_gap(state)
    remark = f"{len(harder_walls())} walls, {iterations} iterations, gap {gap:.0e}"
    outcome = "converged" if unstable == 0 else f"{unstable} unstable modes in the plane"
    return "converged", outcome, check, remark
