"""Files that are wrong or swapped are named for what they are."""

from __future__ import annotations

from pathlib import Path

import h5py
import pytest

from derod import cli, scenes
from derod.branches import Parameters, write_branches
from derod.record import RunWriter
from derod.views.file_kinds import Kind, kind_of
from tests.synthetic import drive, small_scene

Captured = pytest.CaptureFixture[str]


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    place = tmp_path_factory.mktemp("kinds")
    drive(small_scene(), [RunWriter(place / "run.h5")])
    write_branches(place / "ax.h5", Parameters(), [], scenes.text("paper-text"))
    (place / "scene.toml").write_text(scenes.text("quick"))
    (place / "other.toml").write_text("[tool]\nx = 1\n")
    (place / "notes.txt").write_text("nothing = [")
    (place / "film.rrd").write_bytes(b"RRF2" + bytes(20))
    with h5py.File(place / "other.h5", "w") as file:
        file["x"] = 1
    return place


def test_what_files_are(folder: Path) -> None:
    assert {path.name: kind_of(path) for path in folder.iterdir()} == {
        "run.h5": Kind.RUN,
        "ax.h5": Kind.BRANCHES,
        "scene.toml": Kind.SCENE,
        "other.toml": Kind.OTHER,
        "notes.txt": Kind.OTHER,
        "film.rrd": Kind.RERUN,
        "other.h5": Kind.OTHER,
    }
    assert kind_of(folder) is Kind.FOLDER and kind_of(folder / "none") is Kind.OTHER
    assert kind_of("/dev/null") is Kind.OTHER and kind_of("a\0b") is Kind.OTHER


RUN, BRANCHES, SCENE = (kind.value for kind in (Kind.RUN, Kind.BRANCHES, Kind.SCENE))


@pytest.mark.parametrize(
    ("command", "file", "found"),
    [
        (["info", "scene.toml"], "scene.toml", SCENE),
        (["info", "film.rrd"], "film.rrd", "a rerun recording"),
        (["info", "."], ".", "a folder"),
        (["view", "scene.toml"], "scene.toml", SCENE),
        (["plot", "run.h5", "scene.toml"], "scene.toml", SCENE),
        (["export", "scene.toml", "-o", "x.csv"], "scene.toml", SCENE),
        (["movie", "ax.h5"], "ax.h5", BRANCHES),
        (["check", "run.h5"], "run.h5", RUN),
        (["check", "ax.h5"], "ax.h5", BRANCHES),
        (["push", "run.h5"], "run.h5", RUN),
        (["push", "--resume", "ax.h5"], "ax.h5", BRANCHES),
        (["push", "--resume", "scene.toml"], "scene.toml", SCENE),
        (["branch", "run.h5"], "run.h5", RUN),
        (["branch", "--resume", "run.h5"], "run.h5", RUN),
        (["branch", "run.h5", "--export", "auto"], "run.h5", RUN),
        (["compare", "ax.h5", "run.h5"], "ax.h5", BRANCHES),
        (["compare", "run.h5", "run.h5"], "run.h5", RUN),
        (["compare", "run.h5", "scene.toml"], "scene.toml", SCENE),
    ],
)
def test_a_wrong_file_is_named(
    folder: Path,
    monkeypatch: pytest.MonkeyPatch,
    command: list[str],
    file: str,
    found: str,
    capsys: Captured,
) -> None:
    monkeypatch.chdir(folder)
    before = sorted(folder.iterdir())
    assert cli.main(command) == 2
    error = capsys.readouterr().err
    assert error.startswith(f"derod: error: {file}: is {found}") and "; allowed" in error, error
    assert error.count("\n") == 1 and sorted(folder.iterdir()) == before


def test_foreign_hdf5_is_left_to_the_reader(folder: Path, capsys: Captured) -> None:
    assert cli.main(["info", str(folder / "other.h5")]) == 2
    assert "is not a run file of derod" in capsys.readouterr().err


def test_info_of_a_branch_file(folder: Path, capsys: Captured) -> None:
    assert cli.main(["info", str(folder / "ax.h5"), "--verify"]) == 0
    text = capsys.readouterr().out
    assert "0 branches, complete" in text and "l = 10" in text and "verified: all 0" in text
    assert cli.main(["info", str(folder / "ax.h5"), "--si"]) == 2
    assert "--si is for run files" in capsys.readouterr().err
