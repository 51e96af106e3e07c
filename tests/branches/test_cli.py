"""Exit codes and messages of ``derod branch`` and ``derod compare``."""

import argparse
import ast
from pathlib import Path

import pytest

from derod.branches.files.cli import add_branch_parser, add_compare_parser

RUNS = Path(__file__).parents[2] / "runs"
PACKAGE = Path(__file__).parents[2] / "derod" / "branches"


def run(*words):
    parser = argparse.ArgumentParser()
    subparsers = parser.add_subparsers()
    add_branch_parser(subparsers)
    add_compare_parser(subparsers)
    args = parser.parse_args([str(w) for w in words])
    return args.command(args)


def test_branch_writes_and_exports(tmp_path, capsys):
    target = tmp_path / "ax.h5"
    code = run(
        "branch", RUNS / "paper-figures.toml", "-o", target, "--paths", "Ax", "--max-step", 0.5
    )
    assert code == 0
    assert "Ax " in capsys.readouterr().out
    assert run("branch", target, "--export", "auto") == 0
    assert "PT  TY  LAB" in capsys.readouterr().out
    assert run("branch", target, "--export", "auto", "-o", tmp_path / "b.ax") == 0
    assert (tmp_path / "b.ax").read_text().startswith("   0 derod branches of l = 10")


def test_a_path_that_is_not_there_gives_three(tmp_path, capsys):
    target = tmp_path / "b.h5"
    scene = RUNS / "paper-figures.toml"
    assert run("branch", scene, "-o", target, "--paths", "L8", "--max-step", 0.5, "--quiet") == 3
    assert "L8: not met by the paths followed" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["branch", "missing.toml", "-o", "x.h5"], "missing.toml"),
        (["branch", RUNS / "paper-text.toml"], "-o FILE is missing"),
        (["branch", RUNS / "paper-text.toml", "-o", "/no/such/folder/x.h5"], "no such folder"),
        (["branch", RUNS / "paper-text.toml", "-o", "x.h5", "--paths", "Bx"], "'Bx': no such path"),
        (["branch", RUNS / "paper-text.toml", "-o", "x.h5", "--paths", ","], "no name in it"),
        (["branch", RUNS / "paper-text.toml", "-o", "x.h5", "--tolerance", 0], "between 0 and 1"),
        (["branch", RUNS / "paper-text.toml", "--export", "auto"], "paper-text.toml"),
        (["compare", "missing.h5", "missing.h5"], "missing.h5"),
        (["compare", "a.h5", "b.h5", "--tolerance", -1], "must be positive"),
    ],
)
def test_bad_input_gives_two(words, message, capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert run(*words) == 2
    error = capsys.readouterr().err
    assert message in error
    assert error.count("\n") == 1
    assert not list(tmp_path.iterdir())


def test_scenes_outside_the_papers_problem(tmp_path, capsys):
    text = (RUNS / "paper-text.toml").read_text()
    scene = tmp_path / "other.toml"
    scene.write_text(text.replace("bending = 1 ", "bending = [1, 2] ", 1))
    assert run("branch", scene, "-o", tmp_path / "x.h5", "--director", "0.3") == 2
    assert "flip-symmetric" in capsys.readouterr().err
    assert run("branch", scene, "-o", tmp_path / "x.h5", "--director", "east") == 2
    assert "--director = 'east'" in capsys.readouterr().err
    assert not (tmp_path / "x.h5").exists()


def test_two_bending_stiffnesses(tmp_path, capsys):
    text = (RUNS / "paper-text.toml").read_text()
    scene, out = tmp_path / "other.toml", tmp_path / "x.h5"
    scene.write_text(text.replace("bending = 1 ", "bending = [1, 16] ", 1))
    words = ("--paths", "Pt", "--director", "pi/2", "--no-stability", "--max-step", "0.6")
    assert run("branch", scene, "-o", out, *words, "--accuracy", "1e-6", "--quiet") == 0
    assert run("branch", out, "--export", "auto") == 0
    assert "K2/K1 = 16" in capsys.readouterr().out.splitlines()[0]


def test_shares_no_code_with_the_rod():
    """Agreement with the discrete rod is evidence only while nothing is shared."""
    allowed = {"branches", "errors", "exits", "files", "scene", "scenes", "terminal", "views"}
    for path in PACKAGE.rglob("*.py"):
        for node in ast.walk(ast.parse(path.read_text())):
            names = []
            if isinstance(node, ast.Import):
                names = [alias.name for alias in node.names]
            elif isinstance(node, ast.ImportFrom) and node.module in ("derod", "derod.algebra"):
                names = [f"{node.module}.{alias.name}" for alias in node.names]
            elif isinstance(node, ast.ImportFrom):
                names = [node.module or ""]
            for name in names:
                place = name.split(".")
                if place[0] != "derod" or name in ("derod", "derod.algebra.cache"):
                    continue  # ``derod.open_run``: comparing reads a run; a cache for kernels
                assert place[1] in allowed, (path.name, name)
                if place[1] == "views":  # a file draws itself when it is asked to
                    assert path.name == "record.py" and place[2] == "plots", (path.name, name)


def test_rooms_use_the_ones_before_them():
    """half_rod <- paths <- files, whatever the import's place, those for types included."""
    rooms = ("half_rod", "paths", "files")
    for number, room in enumerate(rooms):
        for path in (PACKAGE / room).glob("*.py"):
            text = path.read_text()
            for later in rooms[number + 1 :]:
                assert f"derod.branches.{later}" not in text, (path.name, later)
            assert "from derod.branches import" not in text, path.name


def test_public_names_are_there():
    import derod.branches

    for name in derod.branches.PUBLIC:
        assert callable(getattr(derod.branches, name))
    with pytest.raises(AttributeError, match="no attribute"):
        _ = derod.branches.other


def test_modules_are_short():
    for path in PACKAGE.rglob("*.py"):
        assert len(path.read_text().splitlines()) <= 300, path.name


def test_modules_import_in_one_direction():
    """No circle, imports inside functions and for types included."""
    graph = {}
    for path in PACKAGE.rglob("*.py"):
        name = ".".join(path.relative_to(PACKAGE.parents[1]).with_suffix("").parts)
        graph[name] = set()
        for node in ast.walk(ast.parse(path.read_text())):
            if isinstance(node, ast.ImportFrom) and node.module:
                graph[name] |= {node.module, *(f"{node.module}.{a.name}" for a in node.names)}
    graph.pop("derod.branches.__init__")  # names what is for others
    while graph:
        ready = {name for name, wanted in graph.items() if not (wanted - {name}) & set(graph)}
        assert ready, sorted(graph)
        for name in ready:
            del graph[name]
