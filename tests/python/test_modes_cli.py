"""``derod modes`` and ``derod sensitivities`` from the command line."""

from __future__ import annotations

from pathlib import Path

import h5py
import numpy as np
import pytest

import derod
from derod.cli import main
from tests.scenes import coil


@pytest.fixture(scope="module")
def file(tmp_path_factory) -> Path:
    """A planar run, unstable at its end."""
    path = tmp_path_factory.mktemp("modes") / "coil.h5"
    derod.push(coil(edges=40, stop='"0.4 pi"', at='["0.1 pi"]', noise=0.0), str(path)).close()
    return path


def test_the_table_says_what_is_unstable_and_what_is_left_out(file: Path, capsys) -> None:
    assert main(["modes", str(file), "--at", "0.1 pi, 0.4 pi", "--count", "3"]) == 0
    first, second = capsys.readouterr().out.split("increment ")[1:]
    assert first.count(" stable ") == 3 and second.count("unstable ") >= 1
    assert first.count("left out") == 2 and "its stiffness is" in first
    rows = [line.split() for line in second.splitlines() if line.strip()[:1].isdigit()][1:]
    with derod.open_run(file) as run:
        values = run.modes(-1, 3).eigenvalues
    assert [float(row[1]) for row in rows] == pytest.approx(values, rel=1e-6)
    assert rows[0][2:] == ["unstable", "even", "out"]


def test_a_kick_from_the_command_line_and_a_file_of_answers(file: Path, tmp_path, capsys) -> None:
    out = tmp_path / "modes.h5"
    command = [
        "modes",
        str(file),
        "--count",
        "2",
        "--kick",
        "1",
        "--amplitude",
        "0.02",
        "-o",
        str(out),
    ]
    assert main(command) == 0
    said = capsys.readouterr().out
    assert "kicked along mode 1 by 0.02 D" in said and "to another state" in said
    with h5py.File(out) as kept, derod.open_run(file) as run:
        (group,) = kept.values()
        assert kept.attrs["answers"] == "modes" and group.attrs["increment"] == len(run) - 1
        assert np.array_equal(group["eigenvalues"], run.modes(-1, 2).eigenvalues)
        assert group["eigenvalues"].attrs["unit"] == "K0 D-4"
        assert list(group["plane"].asstr()) == ["out", "in"]
        kicked = group["kicked"]
        assert kicked.attrs["outcome"] == "converged" and kicked.attrs["unstable_modes"] == 0
        assert kicked["positions"].shape == run.positions(-1).shape
        scene = derod.parse_scene(kept.attrs["scene"])
        assert scene == run.scene
    assert main(command) == 2
    assert "exists" in capsys.readouterr().err


def test_pictures_and_streams(file: Path, tmp_path, capsys) -> None:
    picture, recording = tmp_path / "m.png", tmp_path / "m.rrd"
    command = [
        "modes",
        str(file),
        "--count",
        "2",
        "--plot",
        str(picture),
        "--rerun",
        str(recording),
    ]
    assert main(command) == 0
    assert picture.read_bytes().startswith(b"\x89PNG") and recording.read_bytes().startswith(b"RRF")
    capsys.readouterr()


def test_sensitivities(file: Path, tmp_path, capsys) -> None:
    out = tmp_path / "slopes.h5"
    assert main(["sensitivities", str(file), "--at", "0.1 pi", "-o", str(out)]) == 0
    said = capsys.readouterr().out
    rows = {
        line.split()[0]: line.split()[1:] for line in said.splitlines() if line.startswith("  ")
    }
    with derod.open_run(file) as run, h5py.File(out) as kept:
        found = run.at("0.1 pi").sensitivities()
        for name in found.parameters:
            wanted = found[name]
            assert float(rows[name][1]) == pytest.approx(float(wanted["end_tension"]), rel=1e-5)
        (group,) = kept.values()
        assert list(group["parameters"].asstr()) == list(found.parameters)
        assert np.array_equal(group["positions"], found.positions)
        assert group["menisci"].attrs["unit"] == "D per unit of the parameter"
        assert group["eigenvalue"].attrs["unit"] == "K0 D-4"


@pytest.mark.parametrize(
    ("words", "complaint"),
    [
        (["--count", "0"], "--count = 0: allowed: 1, 2, 3"),
        (["--count", "9999"], "k = 9999: allowed: 1 to"),
        (["--count", "2", "--kick", "3"], "--kick = 3: allowed: 1 to 2"),
        (["--kick", "1", "--amplitude", "nan"], "--amplitude = nan: allowed: a length in D"),
        (["--at", "9 pi"], "--at 28.2743 D (9 pi): the run was not there; allowed:"),
        (["--at", "north"], "--at 'north': is not understood as a number"),
        (["--plot", "m.doc"], "--plot = m.doc: allowed"),
        (["--rerun", "web"], "--rerun = web: allowed: spawn, connect"),
    ],
)
def test_what_is_refused(file: Path, capsys, words: list[str], complaint: str) -> None:
    assert main(["modes", str(file), *words]) == 2
    captured = capsys.readouterr()
    assert complaint in captured.err and captured.err.count("\n") == 1 and not captured.out
