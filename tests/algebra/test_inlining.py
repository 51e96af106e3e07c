"""Copying names once leaves the compiled code as it was."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

CODE = """
import copy, sys, time
import derod.algebra
from numba.core import inline_closurecall
mended = inline_closurecall.copy is not copy
if sys.argv[1] == "as numba does":
    inline_closurecall.copy = copy
from derod.algebra.survey import survey
from derod.pushing.exercise import VARIANTS, first_increments
names = sys.argv[2:]
wanted = {one.name: one for one in survey(lambda: first_increments(VARIANTS[0]))}
print(mended)
for name in names:
    wanted[name].compile()
    print(wanted[name].kernel.inspect_asm(wanted[name].types))
"""


def assembly(folder: Path, way: str, *names: str) -> str:
    """The code of kernels compiled in a process of its own."""
    folder.mkdir()
    done = subprocess.run(
        [sys.executable, "-c", CODE, way, *names],
        env=os.environ | {"NUMBA_CACHE_DIR": str(folder), "DEROD_COMPILED": "no"},
        capture_output=True,
        text=True,
        timeout=600,
    )
    assert done.returncode == 0, done.stderr
    mended, _, code = done.stdout.partition("\n")
    assert mended == "True"
    return code


@pytest.mark.parametrize(
    "names",
    [
        ["lay_grid", "excess"],
        pytest.param(["gradient", "follow", "linearise"], marks=pytest.mark.validation),
    ],
)
def test_the_code_is_the_same(tmp_path: Path, names: list[str]) -> None:
    once = assembly(tmp_path / "once", "once", *names)
    assert len(once) > 1000
    assert once == assembly(tmp_path / "numba", "as numba does", *names)
