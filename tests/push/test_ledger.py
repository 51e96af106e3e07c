"""The ledger: energy against work between two settled states."""

from __future__ import annotations

import math
from dataclasses import replace
from unittest.mock import patch

import numpy as np
import pytest

import derod
from derod.equilibrium.energies import Energies
from derod.equilibrium.measured import Measured
from derod.equilibrium.reactions import Reactions
from derod.pushing import increments
from derod.pushing.frames import Outcome
from derod.pushing.ledger import Verdict, compare
from derod.rod.physics import constants
from derod.rod.state import State
from tests.scenes import coil


def on_a_branch(delta: float, holonomy: float = 0.0, energy: float = 0.0) -> Measured:
    """A state of a rod with t = 5 + sin(delta), E_tot = cos(delta) - 5 delta + energy."""
    nothing = np.zeros(3)
    return Measured(
        state=State(np.zeros((3, 4)), np.zeros(8), holonomy, delta, constants(3, 10.0, drop=True)),
        arc_length=np.zeros(3),
        energies=Energies({"bend": math.cos(delta) - 5 * delta + energy}),
        reactions=Reactions(nothing, nothing, nothing, nothing, 0.0),
        settled=True,
        residual=0.0,
        turning=0.1,
        wall_gap=0.1,
        unstable_modes=0,
        slope_q=np.zeros((2, 4)),
        slope_b=np.zeros(8),
        control_value=delta,
        conjugate=-5 - math.sin(delta),
        stiffness=-math.cos(delta),
        sliding_stiffness=math.inf,
        clamp_moment=0.0,
    )


@pytest.mark.parametrize("h", [0.3, -0.3, 0.01, 1.2])
@pytest.mark.parametrize("at", np.linspace(0, 6, 13))
def test_a_smooth_branch_balances(at: float, h: float) -> None:
    entry = compare(on_a_branch(at), on_a_branch(at + h))
    assert entry.verdict is Verdict.BALANCED
    assert abs(entry.defect) < abs(h) ** 5 / 300, "the end correction makes it fourth order"


@pytest.mark.parametrize("h", [0.1, -0.1])
def test_gains_losses_and_jumps_are_told_apart(h: float) -> None:
    start = on_a_branch(1.0)
    for energy, verdict in ((0.05, Verdict.GAINED), (-0.05, Verdict.LOST)):
        entry = compare(start, on_a_branch(1.0 + h, energy=energy))
        assert entry.verdict is verdict
        assert entry.defect == pytest.approx(energy, abs=1e-4)
        assert verdict in entry.message
    assert compare(start, on_a_branch(1.0 + h, holonomy=8.0)).verdict is Verdict.JUMPED
    assert compare(start, on_a_branch(1.0 + h, holonomy=8.0), along=False).verdict is (
        Verdict.BALANCED
    )


def test_a_corner_balances() -> None:
    """At a pitchfork t has a corner between the two states."""
    a, b, corner = on_a_branch(0.0), on_a_branch(0.1), 0.06
    t = -a.conjugate + 3 * corner - 4 * (0.1 - corner)
    work = -(1.5 * corner - a.conjugate) * corner
    work -= (-a.conjugate + 3 * corner - 2 * (0.1 - corner)) * (0.1 - corner)
    a = replace(a, stiffness=-3.0)
    b = replace(b, conjugate=-t, stiffness=4.0, energies=Energies({"bend": a.energy + work}))
    assert compare(a, b).verdict is Verdict.BALANCED


def test_the_push_records_its_balance() -> None:
    """Rows on one branch balance to the end correction's order; a kick's row shows what was lost."""
    run = derod.push(coil(stop='"0.35 pi"'))
    table = run.table
    calm = table["smooth"]
    assert np.abs(table["work_defect"][calm]).max() < 2e-3
    (event,) = [e for e in run.events if e.kind == "instability"]
    lost = event.energy_after - event.energy_before
    assert table["work_defect"][event.increment] == pytest.approx(lost, abs=2e-3)
    assert table["work_defect"].max() < 1e-3


@pytest.mark.parametrize("method", ["follow", "all"])
def test_a_state_that_gains_energy_is_never_recorded(method: str) -> None:
    """With energies lifted from some increment on, the push refuses to go there, and says why."""
    real = increments.measure

    def lifted(system, state, control, tolerance=None):
        here = real(system, state, control, tolerance)
        if state.end_shortening > 0.1 * np.pi:
            here.energies = Energies({**here.energies.parts, "lift": 1.0})
        return here

    with patch.object(increments, "measure", lifted):
        run = derod.push(coil(stop='"0.15 pi"'))
    assert run.ending is not None and run.ending.outcome is Outcome.OUT_OF_BALANCE
    assert "gained" in run.ending.message
    assert run.table["end_shortening"][-1] <= 0.1 * np.pi
    assert len(run) > 3
