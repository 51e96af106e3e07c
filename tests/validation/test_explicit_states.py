"""FIRE and kinetic damping land on the implicit states at four end-shortenings, 100 edges."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parents[2] / "runs"))
from explicit_figures import METHODS, agreement


@pytest.mark.validation
def test_agreement_at_four_end_shortenings() -> None:
    rows = list(agreement(edges=100))
    assert {row.method for row in rows} == set(METHODS)
    assert len(rows) == 8
    for row in rows:
        assert row.outcome == "converged", row
        assert abs(row.energy_difference) < 1e-7, row
        assert abs(row.tension_difference) < 1e-5, row
