"""A wheel with kernels, installed in a new environment with an empty cache: nothing is compiled.

And what comes out is, bit by bit, what kernels compiled on this machine give.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import zipfile
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

ROOT = Path(__file__).parents[2]
pytestmark = pytest.mark.validation

PUSH = """
import json, sys
import derod
from derod.algebra import compiling
from derod.api import push
from derod.pushing.exercise import Variant, small_scene
dimension, drop, method, stop, output = json.loads(sys.argv[1])
scene = small_scene(Variant(dimension, drop, method)).replace(
    {"relax.method": method, "push.stop": stop, "mesh.edges": 30}
)
run = push(scene, output)
print(json.dumps([compiling.kernels(), compiling.seconds(), derod.__file__, str(run.outcome)]))
"""
BRANCHES = """
import json
import derod
from derod.algebra import compiling
from derod.branches.exercise import trace_a_path
trace_a_path()
print(json.dumps([compiling.kernels(), compiling.seconds(), derod.__file__]))
"""
CASES = [
    (3, True, "implicit", "0.4 pi"),  # with an instability on the way
    (2, True, "implicit", "0.4 pi"),
    (3, False, "implicit", "0.2 pi"),
    (2, False, "implicit", "0.2 pi"),
    (3, True, "elliptic", "0.02 pi"),
    (2, True, "elliptic", "0.02 pi"),
    (3, True, "fire", "0.004 pi"),
    (2, True, "kinetic", "0.004 pi"),
]


@pytest.fixture(scope="session")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A wheel with kernels; $DEROD_TEST_WHEEL names one that is made already."""
    made = os.environ.get("DEROD_TEST_WHEEL")
    if made:
        return Path(made)
    folder = tmp_path_factory.mktemp("dist")
    subprocess.run(
        [sys.executable, str(ROOT / "runs" / "build_wheel.py"), "-o", str(folder)], check=True
    )
    (path,) = folder.glob("*.whl")
    return path


@pytest.fixture(scope="session")
def installed(wheel: Path, tmp_path_factory: pytest.TempPathFactory) -> str:
    """The Python of an environment with the wheel."""
    from runs.cold_start import install

    return install(wheel, tmp_path_factory.mktemp("installed") / "venv")


@pytest.fixture
def cache(tmp_path: Path) -> Iterator[Path]:
    """An empty home."""
    folder = tmp_path / "home"
    folder.mkdir(mode=0o755)
    yield folder


def run(python: str, code: str, home: Path, *arguments: str, **more: str) -> list[object]:
    """What a program prints."""
    names = ("CACHE_DIR", "CACHE_HOME", "PYTHONPATH")
    kept = {name: value for name, value in os.environ.items() if not name.endswith(names)}
    done = subprocess.run(
        [python, "-c", code, *arguments],
        cwd=home,
        env=kept | {"HOME": str(home)} | more,
        capture_output=True,
        text=True,
        timeout=1200,
    )
    assert done.returncode == 0, done.stderr
    result: list[object] = json.loads(done.stdout.splitlines()[-1])
    return result


def kept_kernels(home: Path) -> list[Path]:
    return list(home.rglob("*.nbc"))


@pytest.mark.parametrize("case", CASES, ids=lambda case: f"{case[0]}-{case[1]}-{case[2]}")
def test_nothing_is_compiled(installed: str, cache: Path, case: tuple[object, ...]) -> None:
    output = cache / "shipped.h5"
    kernels, seconds, home, outcome = run(installed, PUSH, cache, json.dumps([*case, str(output)]))
    assert (kernels, seconds, outcome) == (0, 0.0, "completed")
    assert "site-packages" in str(home)
    assert not kept_kernels(cache), "nothing is written either"
    same = cache / "compiled.h5"  # by this environment, with kernels of this machine
    run(
        sys.executable,
        PUSH,
        Path.home(),
        json.dumps([*case, str(same)]),
        PYTHONPATH=str(ROOT),
        DEROD_COMPILED="no",
    )
    assert_same(output, same)


def assert_same(one: Path, other: Path) -> None:
    """Raise unless two runs have equal rows and positions, bit by bit."""
    import derod

    with derod.open_run(one) as a, derod.open_run(other) as b:
        assert len(a) == len(b) > 2
        for name in a.table.dtype.names or ():
            if name != "wall_time":
                np.testing.assert_array_equal(a.table[name], b.table[name], err_msg=name)
        for i in range(len(a)):
            assert a.positions(i).tobytes() == b.positions(i).tobytes()


def test_nor_for_branches(installed: str, cache: Path) -> None:
    assert run(installed, BRANCHES, cache)[:2] == [0, 0.0]
    assert not kept_kernels(cache)


def compiled(installed: str, home: Path, **more: str) -> int:
    """How many kernels the first increments compile; only a few are asked for, to be quick."""
    code = (
        "import json\nimport derod.algebra\nfrom derod.algebra import compiling\n"
        "from derod.algebra.survey import survey\n"
        "from derod.pushing.exercise import VARIANTS, first_increments\n"
        "for one in survey(lambda: first_increments(VARIANTS[0])):\n"
        "    if one.name in ('lay_grid', 'excess', 'wall_gap'):\n        one.compile()\n"
        "print(json.dumps([compiling.kernels()]))"
    )
    return int(str(run(installed, code, home, **more)[0]))


def test_what_does_not_fit_is_compiled(installed: str, cache: Path) -> None:
    assert compiled(installed, cache) == 0
    assert compiled(installed, cache, DEROD_COMPILED="no") == 3
    assert compiled(installed, cache) == 0


def test_a_lesser_cpu_compiles(installed: str, cache: Path) -> None:
    lesser = "+64bit,+cmov,+cx8,+fxsr,+mmx,+sse,+sse2"
    assert compiled(installed, cache, NUMBA_CPU_NAME="x86-64", NUMBA_CPU_FEATURES=lesser) == 3


def test_a_users_own_cache_folder_is_left_alone(
    installed: str, cache: Path, tmp_path: Path
) -> None:
    own = tmp_path / "own"
    assert compiled(installed, cache, NUMBA_CACHE_DIR=str(own)) == 0
    assert not list(own.rglob("*.nb?"))


@pytest.mark.parametrize("damage", ["data", "index", "manifest", "source", "writable"])
def test_damage_is_compiled_away(wheel: Path, cache: Path, tmp_path: Path, damage: str) -> None:
    from runs.cold_start import install

    python = install(wheel, tmp_path / "venv")
    (package,) = (tmp_path / "venv").glob("lib/python*/site-packages/derod")
    folder = package / "compiled"
    (lay_grid,) = folder.rglob("grid.lay_grid*.nbi")
    before = compiled(python, cache)
    assert before == 0
    if damage == "writable":
        folder.chmod(0o777)
    elif damage == "source":
        path = package / "algebra" / "bordered.py"
        path.write_text(path.read_text() + "\n# changed\n")
    else:
        data = next(lay_grid.parent.glob("grid.lay_grid*.1.nbc"))
        path = {"data": data, "index": lay_grid, "manifest": folder / "manifest.json"}[damage]
        content = path.read_bytes()
        middle = len(content) // 2
        path.write_bytes(content[:middle] + bytes([content[middle] ^ 4]) + content[middle + 1 :])
    expected = {"data": 1, "index": 1, "manifest": 3, "source": 3, "writable": 3}[damage]
    count = compiled(python, cache)
    assert count == expected or (damage == "manifest" and count <= 3)
    assert compiled(python, cache) == 0, "from the user's cache, by now"


def test_wheels_without_kernels(tmp_path: Path) -> None:
    """``python -m build`` makes a source distribution and, out of it, a pure wheel."""
    subprocess.run(
        [sys.executable, "-m", "build", "--outdir", str(tmp_path), str(ROOT)],
        check=True,
        capture_output=True,
    )
    (wheel,) = tmp_path.glob("derod-*-py3-none-any.whl")
    assert list(tmp_path.glob("derod-*.tar.gz"))
    names = zipfile.ZipFile(wheel).namelist()
    assert "derod/algebra/shipped.py" in names
    assert not [name for name in names if name.startswith("derod/compiled")]
