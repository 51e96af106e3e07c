"""Every python and shell block of README and docs runs, unless it says why it is not run.

Blocks of a page run in order, in one folder that has the repository's ``runs``; Python blocks share their
names. In HTML comments, which readers of the page do not see:

    <!-- not run: REASON -->         the next block is not run
    <!-- run first: COMMAND -->      a shell command before the next block
    <!-- run the last column -->     every code of the last column of the next table is run, `$ ` is shell
"""

from __future__ import annotations

import os
import re
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import pytest

ROOT = Path(__file__).parents[1]
PAGES = sorted([ROOT / "README.md", *(ROOT / "docs").glob("*.md")])
COMMENT = re.compile(
    r"<!--\s*(not run|run first|run the last column)\s*:?\s*(.*?)\s*-->", re.DOTALL
)
FENCE = re.compile(r"```(\w*)")
SHELL, PYTHON = ("bash", "sh", "shell"), ("python",)


class Block(NamedTuple):
    line: int
    language: str
    text: str
    reason: str | None  # why it is not run


def blocks(page: Path) -> Iterator[Block]:
    """What is to be run of a page, in order."""
    lines = page.read_text(encoding="utf-8").splitlines()
    reason, column, i = None, False, 0
    while i < len(lines):
        line = lines[i]
        comment = COMMENT.fullmatch(line.strip())
        fence = FENCE.match(line)
        if comment:
            reason = comment[2] if comment[1] == "not run" else reason
            column = column or comment[1] == "run the last column"
            if comment[1] == "run first":
                yield Block(i + 1, "bash", comment[2], None)
        elif fence:
            end = next(k for k in range(i + 1, len(lines)) if lines[k].startswith("```"))
            if fence[1] in SHELL + PYTHON:
                yield Block(i + 2, fence[1], "\n".join(lines[i + 1 : end]), reason)
            reason, i = None, end
        elif column and line.startswith("|"):
            cell = re.search(r"`([^`]+)`\s*\|$", line)
            if cell:
                shell = cell[1].startswith("$ ")
                yield Block(i + 1, "bash" if shell else "python", cell[1].removeprefix("$ "), None)
        elif column and not line.startswith("|") and line.strip():
            column = False
        i += 1


def run_page(page: Path, folder: Path) -> None:
    names: dict[str, object] = {}
    (folder / "runs").symlink_to(ROOT / "runs")
    environment = os.environ | {
        "PATH": f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}",
        "PYTHONPATH": str(ROOT),
        "MPLBACKEND": "agg",
    }
    for block in blocks(page):
        place = f"{page.name}:{block.line}"
        if block.reason is not None:
            continue
        if block.language in SHELL:
            done = subprocess.run(
                ["bash", "-eo", "pipefail", "-c", block.text],
                cwd=folder, env=environment, capture_output=True, text=True,
            )  # fmt: skip
            assert done.returncode == 0, f"{place}\n{block.text}\n{done.stdout}{done.stderr}"
            continue
        try:
            exec(compile("\n" * (block.line - 1) + block.text, str(page), "exec"), names)
        except Exception as error:
            raise AssertionError(
                f"{place}\n{block.text}\n{type(error).__name__}: {error}"
            ) from error


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_the_blocks_of_a_page_run(
    page: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    pytest.importorskip("matplotlib").use("agg")
    monkeypatch.chdir(tmp_path)
    run_page(page, tmp_path)


def test_a_reason_is_given_for_every_block_that_is_not_run() -> None:
    skipped = [block for page in PAGES for block in blocks(page) if block.reason is not None]
    assert all(len(block.reason or "") > 10 for block in skipped)


def test_every_link_and_picture_of_a_page_is_there() -> None:
    for page in PAGES:
        for target in re.findall(r"\]\(([^)#]+)[^)]*\)", page.read_text(encoding="utf-8")):
            if not re.match(r"https?://|mailto:", target):
                assert (page.parent / target).exists(), f"{page.name}: {target}"
