"""Every hard case ends as it must and passes its own check (runs/hard_cases.py prints the table)."""

from __future__ import annotations

import importlib
import sys
from pathlib import Path

import pytest

RUNS = Path(__file__).parents[3] / "runs"
sys.path.insert(0, str(RUNS))
CASES = importlib.import_module("hard_cases").all_cases()


@pytest.mark.validation
@pytest.mark.parametrize("name", CASES)
def test_it_ends_as_it_must(name: str) -> None:
    result = CASES[name]()
    assert result.good, result
