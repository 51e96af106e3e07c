"""The list of terms: the sums written from it are current, and each term's derivatives are right."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

from derod.equilibrium.energies import PARTS
from derod.pushing.rows import ROW
from derod.rod.physics import CONSTANTS, Physics
from derod.rod.terms import TERMS
from derod.rod.terms.writing import ASSEMBLY, written

ROOT = Path(__file__).parents[2]


def test_the_sums_in_the_assembly_are_those_of_the_list() -> None:
    """If this fails: python -m derod.rod.terms.writing."""
    text = ASSEMBLY.read_text()
    assert written(text, TERMS) == text
    assert written(text, TERMS[:-1]) != text


def test_every_term_has_its_constants_and_its_column() -> None:
    assert set(CONSTANTS) <= set(Physics._fields)
    for part in PARTS:
        assert f"energy_{part}" in (ROW.names or ())
    for term in TERMS:
        assert term.breaks_turn in ("", *CONSTANTS)
        assert term.needs in ("", "drop", "space")


def test_each_term_by_itself_has_exact_derivatives(tmp_path: Path) -> None:
    environment = dict(
        os.environ, NUMBA_DISABLE_JIT="1", PYTHONPATH=str(ROOT), PYTHONWARNINGS="ignore"
    )
    command = [sys.executable, str(Path(__file__).with_name("each_term.py")), str(tmp_path)]
    done = subprocess.run(
        command, capture_output=True, text=True, env=environment, cwd=ROOT, check=False
    )
    assert done.returncode == 0, done.stdout + done.stderr
    assert int(done.stdout.split()[-2]) > 200
