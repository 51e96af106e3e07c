"""Long callees are linked in when their caller has been optimised, and are there when it is loaded."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

CODE = """
import sys
sys.path.insert(0, {folder!r})
import derod.algebra
from derod.algebra import compiling, linking
compiling.is_ours = lambda dispatcher: True
linking.LONG = {long}
import kernels
print(kernels.outer(3.0), sum(kernels.outer.stats.cache_hits.values()), flush=True)
if {long} < 100:
    code = kernels.outer.inspect_llvm(kernels.outer.signatures[0]) if not {loaded} else "call inner"
    print(any("call" in line and "inner" in line for line in code.splitlines()))
"""
KERNELS = """
from numba import njit


@njit(cache=True)
def inner(x):
    return x * x


@njit(cache=True)
def outer(x):
    return inner(x) + inner(x + 1.0)
"""
PUSH = """
import sys
import numpy as np
from derod.algebra import linking
from derod.api import push
if sys.argv[1] == "as numba does":
    linking.LONG = 10**12
from derod.pushing.exercise import VARIANTS, small_scene
run = push(small_scene(VARIANTS[0]).replace({"push.stop": "0.3 pi", "mesh.edges": 40}))
np.save(sys.argv[2], run.table)
"""


def run(code: str, cache: Path, *arguments: str) -> str:
    """What a process with a cache of its own prints."""
    cache.mkdir(mode=0o755, exist_ok=True)
    kept = {name: value for name, value in os.environ.items() if not name.endswith("CACHE_DIR")}
    done = subprocess.run(
        [sys.executable, "-c", code, *arguments],
        env=kept | {"XDG_CACHE_HOME": str(cache), "DEROD_COMPILED": "no"},
        capture_output=True,
        text=True,
        timeout=900,
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_a_callee_linked_last(tmp_path: Path) -> None:
    (tmp_path / "kernels.py").write_text(KERNELS)
    for loaded in (False, True):
        code = CODE.format(folder=str(tmp_path), long=0, loaded=loaded)
        words = run(code, tmp_path / "cache").split()
        assert words == ["25.0", str(int(loaded)), "True"]
    usual = CODE.format(folder=str(tmp_path), long=50_000, loaded=False)
    assert run(usual, tmp_path / "other").split() == ["25.0", "0"]


@pytest.mark.validation
def test_rows_are_the_same(tmp_path: Path) -> None:
    tables = []
    for way in ("last", "as numba does"):
        path = tmp_path / f"{way}.npy"
        run(PUSH, tmp_path / f"cache {way}", way, str(path))
        tables.append(np.load(path))
    last, first = tables
    assert len(last) == len(first) > 5
    for name in last.dtype.names or ():
        if name != "wall_time":
            np.testing.assert_array_equal(last[name], first[name], err_msg=name)
