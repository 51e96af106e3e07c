"""Processes that start together on an empty cache compile each kernel once, and lose none."""

from __future__ import annotations

import os
import subprocess
import sys
import time
from pathlib import Path

import pytest

KERNELS = """
from numba import njit


@njit(cache=True)
def twice(x):
    return x + x
"""
USE = """
import sys, time
sys.path.insert(0, {folder!r})
from derod.algebra.cache import point_numba_at_own_cache
point_numba_at_own_cache()
from derod.algebra import compiling
from numba.core import caching
if {slow}:  # the moment between reading the index and writing it is long
    before = caching.IndexDataCacheFile._save_index
    def save(self, overloads):
        time.sleep(0.3)
        before(self, overloads)
    caching.IndexDataCacheFile._save_index = save
import kernels
print("ready", flush=True)
sys.stdin.readline()
print(kernels.twice({value}), sum(kernels.twice.stats.cache_hits.values()), compiling.seconds())
"""


def start(tmp_path: Path, value: str, *, slow: bool) -> subprocess.Popen[str]:
    """A process that will use the kernel when it gets a line."""
    (tmp_path / "kernels.py").write_text(KERNELS)
    kept = {name: value for name, value in os.environ.items() if not name.endswith("CACHE_DIR")}
    process = subprocess.Popen(
        [sys.executable, "-c", USE.format(folder=str(tmp_path), value=value, slow=slow)],
        env=kept | {"XDG_CACHE_HOME": str(tmp_path / "cache")},
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    )
    assert process.stdout is not None and process.stdout.readline() == "ready\n"
    return process


def together(tmp_path: Path, values: list[str], *, slow: bool = False) -> list[list[str]]:
    """What processes print that use the kernel at the same time."""
    (tmp_path / "cache").mkdir(mode=0o755, exist_ok=True)
    processes = [start(tmp_path, value, slow=slow) for value in values]
    for process in processes:
        assert process.stdin is not None
        process.stdin.write("\n")
        process.stdin.flush()
    return [process.communicate(timeout=120)[0].split() for process in processes]


def test_one_compiles_the_others_load(tmp_path: Path) -> None:
    results = together(tmp_path, ["21", "21", "21"], slow=True)
    assert [result[0] for result in results] == ["42"] * 3
    assert sorted(result[1] for result in results) == ["0", "1", "1"]
    assert all(float(result[2]) > 0 for result in results), "who waits, counts it as compilation"


def test_no_entry_of_an_index_is_lost(tmp_path: Path) -> None:
    values = ["21", "10.5", "2j", "True"]
    results = together(tmp_path, values, slow=True)
    assert [result[1] for result in results] == ["0"] * 4
    again = together(tmp_path, values)
    assert [result[0] for result in again] == ["42", "21.0", "4j", "2"]
    assert [result[1] for result in again] == ["1"] * 4, "all four are kept, under one index"


@pytest.mark.skipif(not hasattr(os, "fork"), reason="locks are POSIX's")
def test_a_claim_ends_with_its_owner(tmp_path: Path) -> None:
    process = start(tmp_path, "21", slow=False)
    holder = subprocess.Popen(
        [
            sys.executable,
            "-c",
            "import sys, time\nfrom pathlib import Path\nfrom derod.algebra import claims\n"
            f"folder = next(Path({str(tmp_path / 'cache')!r}).glob('derod/numba-*/*'))\n"
            f"name = 'kernels.twice-5.py{sys.version_info[0]}{sys.version_info[1]}.claim'\n"
            "with claims.claimed(folder / name):\n    print('held', flush=True)\n    time.sleep(60)\n",
        ],
        stdout=subprocess.PIPE,
        text=True,
    )
    assert holder.stdout is not None and holder.stdout.readline() == "held\n"
    assert process.stdin is not None
    process.stdin.write("\n")
    process.stdin.flush()
    time.sleep(1.0)
    assert process.poll() is None, "it waits"
    holder.kill()
    holder.wait()
    assert process.communicate(timeout=120)[0].split()[0] == "42"
