"""What is said while kernels are compiled, and the process that helps."""

from __future__ import annotations

import io
import json
import os
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import pytest

from derod.algebra import compiling
from derod.cli import compiling as ready
from derod.cli.compiling import Helper, Words, compile_all, start_helper
from derod.pushing.exercise import VARIANTS, small_scene, variant_of
from tests.test_progress import Terminal

ROOT = Path(__file__).parents[1]


def test_lines_off_a_terminal(capsys: pytest.CaptureFixture[str]) -> None:
    words = Words(18, io.StringIO())
    words("gradient", True)
    words("hessian", True)  # too soon for another line
    words.shown -= ready.LINE_EVERY
    words("gradient", False)
    words("follow", True)
    assert capsys.readouterr().err.splitlines() == [
        "compiling kernels, 1 of 18 (gradient)",
        "compiling kernels, 2 of 18 (follow, hessian)",
    ]


def test_one_line_on_a_terminal() -> None:
    stream = Terminal()
    words = Words(3, stream)
    for name in ("gradient", "hessian", "excess"):
        words(name, True)
        words(name, False)
    words.clear()
    shown = stream.getvalue()
    assert "\n" not in shown and shown.endswith("\r")
    assert "compiling kernels, 3 of 3 (excess)" in shown
    assert "4 of 3" not in shown


def test_nobody_reads_the_terminal() -> None:
    class Gone(Terminal):
        def write(self, text: str) -> int:
            raise BrokenPipeError

    Words(3, Gone())("gradient", True)


def test_compilation_is_left_out_of_the_clock() -> None:
    before, clock = compiling.seconds(), compiling.clock()
    with compiling.waiting():
        time.sleep(0.05)
        assert compiling.seconds() - before >= 0.05, "also while it goes on"
    assert compiling.seconds() - before >= 0.05
    assert compiling.clock() - clock < 0.04
    assert compiling.take() >= 0.05 and compiling.take() == 0.0


def test_a_helper_that_fails_is_named(capsys: pytest.CaptureFixture[str]) -> None:
    class Nonsense:
        __module__ = "derod.no_such_module"
        __qualname__ = "kernel"

    class Wanted:
        kernel = type("Kernel", (), {"py_func": Nonsense})
        types = ()

    helper = Helper([Wanted()], [], lambda name, begins: None)  # type: ignore[list-item]
    assert helper.finished.wait(60)
    helper.process.wait(60)
    helper.end()
    assert "No module named 'derod.no_such_module'" in capsys.readouterr().err


def test_a_helper_ends_with_its_parent() -> None:
    code = (
        "import os\nfrom derod.cli.compiling import Helper\n"
        "helper = Helper([], [], print)\nprint(helper.process.pid, flush=True)\n"
        "os.kill(os.getpid(), 9)\n"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=60)
    pid = int(done.stdout.split()[0])
    for _ in range(600):
        try:
            state = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0]
        except (FileNotFoundError, ProcessLookupError):
            return
        if state == "Z":
            return
        time.sleep(0.1)
    pytest.fail("the helper has outlived its parent")


def test_one_core_does_it_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(ready, "cores", lambda: 1)
    assert start_helper([None, None], [], lambda name, begins: None) is None  # type: ignore[list-item]


def test_what_others_are_at_comes_last(monkeypatch: pytest.MonkeyPatch) -> None:
    from derod.algebra import claims

    class Wanted:
        def __init__(self, kernel: str) -> None:
            self.kernel = kernel

        def compile(self) -> None:
            done.append(self.kernel)
            busy.clear()

    done: list[str] = []
    busy = {"a"}
    monkeypatch.setattr(claims, "claim_path", lambda kernel: kernel)
    monkeypatch.setattr(claims, "is_claimed_elsewhere", lambda path: path in busy)
    compile_all([Wanted("a"), Wanted("b"), Wanted("c")])  # type: ignore[list-item]
    assert done == ["b", "a", "c"]


def test_the_ready_note(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    folder: Any = tmp_path
    monkeypatch.setattr(ready, "own_folder", lambda: folder)
    monkeypatch.setenv("DEROD_COMPILED", "no")
    assert not ready.is_ready(VARIANTS[0])
    ready.note_ready(VARIANTS[0])
    ready.note_ready(VARIANTS[1])
    assert ready.is_ready(VARIANTS[0]) and ready.is_ready(VARIANTS[1])
    assert not ready.is_ready(VARIANTS[2])
    assert sorted(json.loads((tmp_path / ready.READY).read_text())) == sorted(
        [VARIANTS[0].name, VARIANTS[1].name]
    )
    (tmp_path / ready.READY).write_text("{")
    assert not ready.is_ready(VARIANTS[0]), "damaged: looked at again"
    folder = None
    ready.note_ready(VARIANTS[0])
    assert not ready.is_ready(VARIANTS[0])


@pytest.mark.parametrize("variant", VARIANTS, ids=lambda variant: variant.name)
def test_variants_have_scenes_of_their_kind(variant: Any) -> None:
    scene = small_scene(variant).replace({"relax.method": variant.method})
    assert variant_of(scene) == variant


def test_warmup_of_a_scene(tmp_path: Path) -> None:
    """The kernels are in the tests' cache by then, or are compiled now."""
    scene = str(ROOT / "runs" / "quick.toml")
    done = subprocess.run(
        [sys.executable, "-m", "derod", "warmup", scene],
        capture_output=True,
        text=True,
        timeout=900,
    )
    assert done.returncode == 0, done.stderr
    assert " kernels of 1 kinds of pushes are in " in done.stdout
    again = subprocess.run(
        [sys.executable, "-m", "derod", "warmup", "--quiet", scene],
        capture_output=True,
        text=True,
        timeout=60,
    )
    assert (again.returncode, again.stdout, again.stderr) == (0, "", "")


@pytest.mark.skipif(os.geteuid() != 0, reason="a folder that nobody may write is root's")
def test_warmup_without_a_cache_that_lasts(tmp_path: Path) -> None:
    home = tmp_path / "home"
    home.mkdir()
    home.chmod(0o777)
    kept = {name: value for name, value in os.environ.items() if not name.endswith("CACHE_DIR")}
    kept.pop("XDG_CACHE_HOME", None)
    code = (
        "from derod.cli import warmup, main\nwarmup.kernels_of = lambda variants: []\n"
        f"import sys; sys.exit(main(['warmup', {str(ROOT / 'runs' / 'quick.toml')!r}]))"
    )
    done = subprocess.run(
        [sys.executable, "-c", code],
        env=kept | {"HOME": str(home), "TMPDIR": str(home)},
        capture_output=True,
        text=True,
        timeout=120,
    )
    assert done.returncode == 3, done.stderr
    assert "cannot be kept" in done.stderr
