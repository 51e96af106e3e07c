"""Workers without rerun, pyarrow and matplotlib do everything but view and draw."""

from __future__ import annotations

import re
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
BLOCKED = (
    "rerun",
    "rerun_sdk",
    "rerun_bindings",
    "pyarrow",
    "matplotlib",
    "PIL",
    "pandas",
    "xarray",
)
BLOCKER = f"""
import sys

class Blocker:
    def find_spec(self, name, path=None, target=None):
        if name.partition(".")[0] in {BLOCKED!r}:
            raise ModuleNotFoundError(f"No module named {{name!r}}", name=name)

sys.meta_path.insert(0, Blocker())
from derod.cli import main
code = main(sys.argv[1:])
assert not set({BLOCKED!r}) & set(sys.modules)
sys.exit(code)
"""


def run(folder: Path, *words: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-c", BLOCKER, *words], cwd=folder, capture_output=True, text=True
    )


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("slim")


def test_everything_but_viewing_and_drawing(folder: Path) -> None:
    for words in (
        "check quick",
        "push quick --edges 60 --stop 0.1",
        "push --resume quick.h5 --stop 0.2",
        "info quick.h5 --verify",
        "branch quick --paths Ax --max-step 0.5 --accuracy 1e-5 --no-stability",
        "info quick-branches.h5",
        "branch quick-branches.h5 --export auto",
        "compare quick.h5 quick-branches.h5 --tolerance 0.01",
        "export quick.h5 -o rows.csv",
        "export quick.h5 -o coil.pvd",
        "scenes",
        "init my.toml",
        "completion bash",
    ):
        done = run(folder, *words.split())
        assert done.returncode == 0, (words, done.stderr)


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (
            "plot quick.h5",
            "a picture needs matplotlib, which is not installed: pip install matplot",
        ),
        ("movie quick.h5", "a picture needs matplotlib, which is not installed"),
        ("view quick.h5", "derod view needs rerun-sdk, which is not installed: pip install rerun-"),
        ("push quick -o b.h5 --rerun spawn", "--rerun needs rerun-sdk, which is not installed"),
    ],
)
def test_what_is_missing_is_named(folder: Path, words: str, told: str) -> None:
    if not (folder / "quick.h5").exists():
        run(folder, *["push", "quick", "--edges", "60", "--stop", "0.1", "--quiet"])
    before = sorted(folder.iterdir())
    done = run(folder, *words.split())
    assert done.returncode == 2 and f"derod: error: {told}" in done.stderr, done.stderr
    lines = [line for line in done.stderr.splitlines() if not line.endswith("; loading kernels")]
    assert len(lines) == 1 and sorted(folder.iterdir()) == before


def test_the_requirements_of_a_worker_are_the_package_without_its_viewers() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    lines = (ROOT / "requirements-core.txt").read_text().splitlines()
    core = {line for line in lines if line and not line.startswith("#")}
    rest = {re.split("[>=]", one)[0] for one in set(project["dependencies"]) - core}
    assert core < set(project["dependencies"]) and rest == {"rerun-sdk", "matplotlib"}
