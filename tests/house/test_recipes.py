"""CONTRIBUTING's recipes, proved: a toy term, control, column and view, each one file and one line."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]


@pytest.fixture(scope="module")
def seen(tmp_path_factory: pytest.TempPathFactory) -> dict:
    folder = tmp_path_factory.mktemp("toys")
    environment = dict(
        os.environ,
        NUMBA_DISABLE_JIT="1",
        PYTHONPATH=str(ROOT),
        PYTHONWARNINGS="ignore",
        MPLBACKEND="agg",
    )
    done = subprocess.run(
        [sys.executable, str(Path(__file__).with_name("toys.py")), str(folder)],
        capture_output=True,
        text=True,
        env=environment,
        cwd=ROOT,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout.splitlines()[-1])


def test_a_term_is_in_energies_merit_gradient_and_hessian(seen: dict) -> None:
    assert seen["energy"] == pytest.approx(seen["expected"], rel=1e-14)
    assert seen["merit"] == pytest.approx(seen["expected"], rel=1e-9)
    assert seen["gradient"] == pytest.approx(seen["gradient_differences"], rel=1e-6)
    assert seen["hessian"] == pytest.approx(seen["hessian_differences"], rel=1e-6)


def test_a_control_pushes_and_balances_its_work(seen: dict) -> None:
    assert seen["outcome"] == "completed"
    assert seen["springs"] == [2.0, 4.0]
    assert seen["gained"] == pytest.approx(seen["work"], rel=5e-3)  # five rows
    assert seen["gained"] > 0


def test_columns_are_in_the_file_with_their_units(seen: dict) -> None:
    assert seen["units"] == {"spring": "K0 D-3", "drop_tilt": "rad", "energy_spring": "K0 D-1"}
    assert seen["tilts"] < 1e-12  # a planar rod's drop is above or below the axis


def test_a_view_is_drawn(seen: dict) -> None:
    assert seen["labels"] == ["tilt, rad"]
    assert seen["picture"] > 1000
