"""Landings beside joints on twenty random scenes: none on the wrong path, errors below 1e-7."""

import subprocess
import sys
from pathlib import Path

import pytest

pytestmark = pytest.mark.validation
COMMAND = Path(__file__).parents[2] / "runs" / "landings.py"


def test_twenty_random_scenes():
    words = [sys.executable, str(COMMAND), "--count", "20", "--seed", "1"]
    done = subprocess.run(words, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    assert done.stdout.splitlines()[-1].startswith("20 scenes, ")
    assert " 0 wrong, 0 missing" in done.stdout.splitlines()[-1]
