"""Scenes built in code: the checks and the messages of files."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import derod
from derod.scene import Scene as CheckedScene
from derod.scene import load_scene
from derod.scenes import read_scene

ROD = {"length": 10, "bending": 1, "twisting": 0.9}
DROP = {"capillary_force": 20, "wall_strength": 2e-4, "wall_softness": 0.1}
PUSH = {"start": "0.001 pi", "stop": "0.6 pi", "at": ["0.1 pi", "0.25 pi", "0.5 pi"],
        "max_step": "0.02 pi"}  # fmt: skip


def test_tables() -> None:
    built = derod.Scene(rod=ROD, drop=DROP, push=PUSH, mesh={"edges": 150})
    assert isinstance(built, CheckedScene) and isinstance(built, derod.Scene)
    assert built == read_scene("quick")
    assert built.path is None and read_scene("quick").path == "quick"
    flat = {f"{table}.{key}": value for table, keys in
            {"rod": ROD, "drop": DROP, "push": PUSH}.items() for key, value in keys.items()}  # fmt: skip
    assert derod.Scene(None, {**flat, "mesh.edges": 150}) == built


def test_from_another_scene(tmp_path: Path) -> None:
    quick = read_scene("quick")
    file = tmp_path / "my.toml"
    file.write_text(quick.text)
    for base in ("quick", quick, file, str(file)):
        assert derod.Scene(base) == quick
        made = derod.Scene(base, {"push.stop": "0.3 pi"}, mesh={"edges": np.int64(60)})
        assert made.mesh.edges == 60 and made.push.at == pytest.approx([0.1 * np.pi, 0.25 * np.pi])
        assert made.mesh.layer == quick.mesh.layer
    assert derod.Scene("quick", drop=quick.drop, rod=quick.rod) == quick
    dry = derod.Scene("quick", drop=None, model={"drop": False})
    assert dry.drop is None


@pytest.mark.parametrize(
    ("tables", "words"),
    [
        ({"rod": {**ROD, "length": 0.5}}, r"scene: rod.length = 0.5 is out of range; allowed: "),
        ({"rod": {**ROD, "lenght": 1}}, r"rod.lenght is unknown.*did you mean"),
        ({"rod": {"length": 10}}, r"rod.bending is missing"),
        ({"rods": ROD}, r"rods is unknown"),
        ({"rod": 3}, r"rod = 3 is not a table"),
        ({"push": {**PUSH, "stop": "20 pi"}}, r"push.stop = \"20 pi\" is a push past"),
    ],
)
def test_the_messages_of_files(tables: dict, words: str) -> None:
    with pytest.raises(derod.SceneError, match=words):
        derod.Scene(**{"rod": ROD, "drop": DROP, "push": PUSH, **tables})


def test_a_base_is_named_in_messages() -> None:
    with pytest.raises(derod.SceneError, match=r"^quick: mesh.edges = 3 is out of range"):
        derod.Scene("quick", mesh={"edges": 3})
    with pytest.raises(derod.SceneError, match=r"^quick: mesh.edges = 3 is out of range"):
        derod.Scene("quick", {"mesh.edges": 3})


def test_faces(tmp_path: Path) -> None:
    quick = read_scene("quick")
    assert repr(quick) == (
        "<scene quick: l = 10, f_gamma = 20, v0 = 0.0002, rho = 0.1, from "
        "0.00314159 D (0.001 pi), end-shortening to 1.88496 D (0.6 pi), 150 edges>"
    )
    assert "no drop" in repr(derod.Scene("quick", drop=None, model={"drop": False}))
    html = quick._repr_html_()
    assert "elastocapillary" in html and "[rod]" in html and html.count("<table>") == 1
    file = tmp_path / "a<b.toml"
    file.write_text(quick.text)
    assert "a&lt;b.toml" in load_scene(file)._repr_html_()
    assert (
        "in SI" not in repr(read_scene("tpu-fibre"))
        and "<table>" in read_scene("tpu-fibre")._repr_html_()
    )
