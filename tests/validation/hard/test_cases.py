"""Every hard case ends as it must, in stable equilibria, with the energy balance of the end's work."""

from __future__ import annotations

import runpy
from pathlib import Path

import numpy as np
import pytest

STUDY = runpy.run_path(str(Path(__file__).parents[3] / "runs" / "hard_cases.py"))


@pytest.mark.validation
@pytest.mark.parametrize("name", STUDY["CASES"])
def test_it_ends_as_it_must(name: str) -> None:
    case = STUDY["CASES"][name]
    run = STUDY["run_case"](case)
    assert run.ending is not None
    assert run.ending.outcome is case.ending, run.ending.message
    table = run.table
    assert table["converged"].all()
    assert (table["unstable_modes"] == 0).all()
    assert table["residual"].max() < 1e-5
    assert table["wall_gap"].min() > 0
    smooth = table["smooth"][1:]
    step = np.diff(table["end_shortening"])
    mean = 0.5 * (table["end_tension"][1:] + table["end_tension"][:-1])
    drift = np.abs(np.diff(table["energy_total"]) + mean * step)[smooth]
    # the trapezoid's error where t has a kink (a pitchfork): step^2 times t's steepest slope
    steepest = np.abs(np.diff(table["end_tension"]) / step)[smooth].max()
    assert (drift <= steepest * step[smooth] ** 2 + 1e-6).all()
