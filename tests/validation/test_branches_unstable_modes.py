"""Counts of unstable modes: the discrete rod against the branches, both paper scenes, all paths."""

import re
import subprocess
import sys
from pathlib import Path

import pytest

pytestmark = pytest.mark.validation
COMMAND = Path(__file__).parents[2] / "runs" / "unstable_modes.py"


def test_every_fourth_point_of_all_named_paths():
    done = subprocess.run(
        [sys.executable, str(COMMAND)], capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stdout + done.stderr
    last = done.stdout.splitlines()[-1]
    looked, different, lost = map(int, re.findall(r"(\d+) (?:states|counts|not)", last))
    assert looked > 300
    assert (different, lost) == (0, 0)
