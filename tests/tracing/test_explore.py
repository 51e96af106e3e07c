"""Explorations: each path once, kept in a file, gone on with; and what bad input is told."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from derod.cli import main
from derod.diagram.reading import read_diagram
from derod.errors import RecordError
from tests.scenes import COIL

BOUNDED = ["--energy", "16", "--modes", "1", "--strong", "0", "--to", "0, 1.2 pi", "--quiet"]


@pytest.fixture(scope="module")
def scene(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("explore") / "coil.toml"
    given = {"edges": 60, "wall": 2e-4, "rotation": 0, "noise": 1e-3, "dimension": 3}
    path.write_text(COIL.format(stop='"0.3 pi"', at="[]", **given))
    return path


@pytest.fixture(scope="module")
def explored(scene: Path) -> Path:
    out = scene.with_name("whole.h5")
    assert main(["explore", str(scene), "-o", str(out), *BOUNDED]) == 0
    return out


def test_an_exploration_keeps_its_paths(explored: Path) -> None:
    diagram = read_diagram(explored)
    assert diagram.complete
    assert len(diagram.paths) >= 2
    first, second = list(diagram.paths.values())[:2]
    assert first.character == "planar, flip-even"
    assert (
        first.specials["partner"][first.specials["kind"] == b"branch point"][0]
        == second.name.encode()
    )
    assert np.all(np.diff(first.table["path_arc"]) > 0)
    assert second.table["unstable_modes"][0] == 0


def test_an_exploration_that_was_stopped_goes_on(scene: Path, explored: Path) -> None:
    out = scene.with_name("stopped.h5")
    assert main(["explore", str(scene), "-o", str(out), "--paths", "1", *BOUNDED]) == 3
    assert not read_diagram(out).complete
    assert main(["explore", "--resume", str(out), "--paths", "60", "--quiet"]) == 0
    whole, again = read_diagram(explored), read_diagram(out)
    assert list(whole.paths) == list(again.paths)
    for one, other in zip(whole.paths.values(), again.paths.values(), strict=True):
        assert other.character == one.character
        assert other.specials["value"] == pytest.approx(one.specials["value"], rel=1e-7)


def test_a_damaged_diagram_is_refused(explored: Path) -> None:
    data = bytearray(explored.read_bytes())
    place = data.find(read_diagram(explored).paths["P1"].positions[5].tobytes())
    data[place + 100] ^= 1
    broken = explored.with_name("broken.h5")
    broken.write_bytes(data)
    with pytest.raises(RecordError, match="checksum"):
        read_diagram(broken)


def test_a_trace_from_a_run_passes_its_state(scene: Path) -> None:
    run, out = scene.with_name("run.h5"), scene.with_name("trace.h5")
    assert main(["push", str(scene), "-o", str(run), "--stop", "0.2 pi", "--quiet"]) == 0
    options = ["--at", "0.2 pi", "--to", "0.1 pi, 0.4 pi", "--quiet"]
    assert main(["trace", str(run), "-o", str(out), *options]) == 0
    diagram = read_diagram(out)
    assert json.loads(diagram.command)["at"] == "0.2 pi"
    (path,) = diagram.paths.values()
    assert path.table["end_shortening"].min() < 0.1 * np.pi
    assert path.table["end_shortening"].max() > 0.4 * np.pi


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["trace", "SCENE", "--control", "colour"], "--control = 'colour': is none; allowed: end_"),
        (
            ["trace", "SCENE", "--control", "weight"],
            "allowed for a scene: end_shortening, end_tension",
        ),
        (["trace", "SCENE", "--mode", "0"], "--mode = 0: allowed: 1 to 20"),
        (
            ["trace", "SCENE", "--to", "2, 1"],
            "--to = '2, 1': allowed: two numbers, the lower one first",
        ),
        (["trace", "SCENE", "--to", "here"], "--to = 'here': allowed: two numbers"),
        (["trace", "SCENE", "--at", "1"], "--at and --path are for run and branch files"),
        (["trace", "SCENE", "--points", "0"], "--points = 0: allowed: 1 to 100000"),
        (["explore", "SCENE", "--strong", "0.5"], "--strong = 0.5: allowed: 0, or above 1"),
        (["explore", "SCENE", "--energy", "-1"], "--energy = -1: allowed: a number above 0"),
        (["explore", "SCENE", "--at", "x"], "--at = 'x': is not understood as a number"),
        (["explore"], "explore needs SCENE"),
    ],
)
def test_bad_input_is_one_line(
    arguments: list[str], words: str, scene: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    filled = [str(scene) if one == "SCENE" else one for one in arguments]
    assert main([*filled, "--quiet"]) == 2
    complaint = capsys.readouterr().err
    assert words in complaint
    assert complaint.count("\n") == 1
