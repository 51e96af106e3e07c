"""The notebooks run without a warning; the site builds strictly, and loads nothing from elsewhere."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
NOTEBOOKS = sorted((ROOT / "docs" / "notebooks").glob("*.py"))
PAGES = sorted((ROOT / "docs").glob("*.md"))
RESOURCE = re.compile(
    r"<(?:script|img|iframe)[^>]*\ssrc=\"(https?:)?//|<link rel=\"?stylesheet\"? href=\"https?:"
)


def environment() -> dict[str, str]:
    return os.environ | {"MPLBACKEND": "agg", "PYTHONPATH": str(ROOT), "OPENBLAS_NUM_THREADS": "1"}


@pytest.mark.parametrize("notebook", NOTEBOOKS, ids=lambda path: path.stem)
def test_a_notebook_runs_without_a_warning(notebook: Path, tmp_path: Path) -> None:
    pytest.importorskip("matplotlib")
    done = subprocess.run(
        [sys.executable, "-W", "error", str(notebook)],
        cwd=tmp_path, env=environment(), capture_output=True, text=True, timeout=300,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert not re.search(r"warning", done.stderr, re.IGNORECASE), done.stderr
    assert not list(tmp_path.iterdir())


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    for name in ("mkdocs", "material", "mkdocstrings", "mkdocs_jupyter", "latex2mathml"):
        pytest.importorskip(name)
    folder = tmp_path_factory.mktemp("site")
    done = subprocess.run(
        [sys.executable, "-m", "mkdocs", "build", "--strict", "--site-dir", str(folder)],
        cwd=ROOT, env=environment() | {"NO_MKDOCS_2_WARNING": "1"}, capture_output=True, text=True,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    warnings = [line for line in done.stderr.splitlines() if line.startswith("WARNING")]
    assert not warnings
    return folder


def test_every_page_is_in_the_site(site: Path) -> None:
    for page in PAGES:
        assert (site / f"{page.stem}.html").exists(), page
    for notebook in NOTEBOOKS:
        text = (site / "notebooks" / f"{notebook.stem}.html").read_text(encoding="utf-8")
        assert text.count("data:image/png;base64") + text.count("<img") >= 2, notebook
        assert "jp-OutputArea-output" in text
        body = re.sub(r"<style.*?</style>", "", text, flags=re.DOTALL)
        assert "vnd.jupyter.stderr" not in body, notebook


def test_the_api_is_there(site: Path) -> None:
    text = (site / "api.html").read_text(encoding="utf-8")
    for name in (
        "derod.push",
        "derod.branch",
        "derod.record.BaseRun.modes",
        "derod.views.plots.plot",
    ):
        assert f'id="{name}"' in text


def test_formulas_are_mathml_and_nothing_is_loaded_from_elsewhere(site: Path) -> None:
    pages = list(site.rglob("*.html"))
    assert "<math" in (site / "figures.html").read_text(encoding="utf-8")
    for page in pages:
        text = page.read_text(encoding="utf-8")
        assert 'class="arithmatex"' not in text, page
        assert not RESOURCE.search(text), (page, RESOURCE.search(text))


@pytest.mark.parametrize("name", ["scene_reference", "cli_reference"])
def test_references_say_what_the_code_does(name: str) -> None:
    """If this fails: python runs/scene_reference.py, or cli_reference.py."""
    command = [sys.executable, str(ROOT / "runs" / f"{name}.py"), "--check"]
    assert subprocess.run(command, env=environment(), check=False).returncode == 0
