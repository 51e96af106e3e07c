"""Something to run: scenes that ship, the one that is begun with, and default outputs."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import pytest

from derod import cli, errors, open_run, scenes
from derod.scene import load_scene, parse_scene
from derod.scene.rules import KEYS
from derod.scene.tables import Scene

RUNS = Path(__file__).parents[1] / "runs"
Captured = pytest.CaptureFixture[str]


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_the_scenes_of_runs_are_the_shipped_ones() -> None:
    assert {path.stem for path in RUNS.glob("*.toml")} == set(scenes.names())
    for path in RUNS.glob("*.toml"):
        assert path.read_text(encoding="utf-8") == scenes.text(path.stem)
        assert Path(scenes.file_of(path.stem)).read_text() == scenes.text(path.stem)


def test_the_list(here: Path, capsys: Captured) -> None:
    assert cli.main(["scenes"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert [line.split()[0] for line in lines[: len(scenes.names())]] == list(scenes.names())
    assert scenes.names()[0] == "quick"
    for name in scenes.names():
        assert 20 < len(scenes.headline(name)) < 110 and scenes.headline(name).endswith(".")
    assert cli.main(["scenes", "quick"]) == 0
    assert capsys.readouterr().out == scenes.text("quick")
    assert cli.main(["scenes", "quik"]) == 2
    assert "ships with derod; allowed: quick, " in capsys.readouterr().err


def test_the_scene_to_begin_with_has_every_key_and_says_the_defaults() -> None:
    text = scenes.text(scenes.NEW)
    for table in KEYS.keys() - {"steps"}:
        part = re.split(r"^\[", text.split(f"[{table}]")[1], maxsplit=1, flags=re.MULTILINE)[0]
        for key in KEYS[table]:
            found = re.search(rf"^(# )?{key} = .* # ", part, re.MULTILINE)
            assert found, f"{table}.{key} does not say what it is"
    assert "[[steps]]" in text
    scene = parse_scene(text)
    defaults = scene.replace({"mesh": {}, "relax": {}, "noise": {}, "model": {}})
    assert scene == defaults


def test_init(here: Path, capsys: Captured) -> None:
    assert cli.main(["init", "my.toml"]) == 0
    assert "derod push my.toml" in capsys.readouterr().out
    assert isinstance(load_scene("my.toml"), Scene)
    before = Path("my.toml").read_text()
    assert cli.main(["init", "my.toml", "--like", "quick"]) == 2
    assert "--force replaces it" in capsys.readouterr().err
    assert Path("my.toml").read_text() == before and "derod push my.toml" in before
    assert cli.main(["init", "my.toml", "--like", "quick", "--force"]) == 0
    assert Path("my.toml").read_text() == scenes.text("quick")
    assert cli.main(["init", "my.h5"]) == 2 and not Path("my.h5").exists()


def test_a_shipped_scene_runs_and_its_run_has_a_name(here: Path, capsys: Captured) -> None:
    command = ["push", "quick", "--edges", "40", "--stop", "0.01 pi"]
    assert cli.main(command) == 0
    assert "next: derod info quick.h5, derod plot quick.h5" in capsys.readouterr().out
    with open_run("quick.h5") as run:
        assert run.scene.mesh.edges == 40
    size = Path("quick.h5").stat()
    assert cli.main(command) == 2
    error = capsys.readouterr().err
    assert error == (
        "derod: error: quick.h5: exists already; --force replaces it, -o FILE writes another, "
        "--resume goes on with it\n"
    )
    assert Path("quick.h5").stat() == size
    assert cli.main([*command, "--force", "--quiet"]) == 0


def test_a_scenes_run_goes_beside_it(here: Path) -> None:
    Path("a b").mkdir()
    Path("a b/my.toml").write_text(scenes.text("quick"))
    short = ["--edges", "40", "--stop", "0.01 pi", "--quiet"]
    assert cli.main(["push", "a b/my.toml", *short]) == 0
    assert Path("a b/my.h5").exists()
    Path("quick").write_text(scenes.text("quick").replace("150", "44"))
    assert cli.main(["push", "quick", "--stop", "0.01 pi", "--quiet"]) == 0
    with open_run("quick.h5") as run:  # a file comes before a shipped scene
        assert run.scene.mesh.edges == 44


@pytest.mark.parametrize(
    ("name", "allowed"),
    [("quik", "a file's path, or quick"), ("quick.toml", "or quick (shipped"),
     ("x/quick.toml", "or quick (shipped"), ("zebra", "or quick, end-tension")],
)  # fmt: skip
def test_names_that_are_not_there(here: Path, name: str, allowed: str, capsys: Captured) -> None:
    for command in (["push", name], ["check", name], ["branch", name]):
        assert cli.main(command) == 2
        error = capsys.readouterr().err
        assert error.startswith(f"derod: error: {name}: cannot be read: ") and allowed in error


def test_a_path_that_is_not_there_is_no_shipped_scene(here: Path) -> None:
    with pytest.raises(errors.SceneError, match="No such file"):
        scenes.read_scene("deep/mine.toml")


def test_completion_knows_commands_and_options(here: Path) -> None:
    for shell in ("bash", "zsh"):
        done = subprocess.run(
            [sys.executable, "-m", "derod", "completion", shell], capture_output=True, text=True
        )
        assert done.returncode == 0, done.stderr
        for word in ("push", "scenes", "--extrapolate", "compare"):
            assert word in done.stdout
        Path(f"derod.{shell}").write_text(done.stdout)
    ask = (
        "source ./derod.bash; COMP_WORDS=(derod {0}); COMP_CWORD={1}; "
        "_shtab_derod; printf '%s\\n' \"${{COMPREPLY[@]}}\""
    )
    for words, count, wanted in (("pu", 1, "push"), ("push --ext", 2, "--extrapolate")):
        said = subprocess.run(
            ["bash", "-c", ask.format(words, count)], capture_output=True, text=True
        )
        assert said.stdout.split() == [wanted], said.stderr
