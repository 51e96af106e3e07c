"""Runs as H5MD: what is in the file, and that MDAnalysis opens it."""

from __future__ import annotations

import re
import warnings
from pathlib import Path

import h5py
import numpy as np
import pytest

from derod.cli import main
from derod.exits import UsageError
from derod.scene import parse_scene
from derod.views.export import export

PAGE = Path(__file__).parents[2] / "docs" / "plots.md"


@pytest.fixture
def exported(run, tmp_path):
    path = tmp_path / "coil.h5md"
    assert export(run, path) == [path]
    return path


def test_the_file_is_h5md(run, exported):
    with h5py.File(exported) as file:
        assert list(file["h5md"].attrs["version"]) == [1, 1]
        assert file["h5md/author"].attrs["name"] and file["h5md/creator"].attrs["name"] == "derod"
        assert list(file["particles"]) == ["trajectory"]
        box = file["particles/trajectory/box"]
        assert box.attrs["dimension"] == 3 and list(box.attrs["boundary"]) == ["none"] * 3
        elements = [file["particles/trajectory/position"], *file["observables"].values()]
        for element in elements:
            assert np.array_equal(element["step"], np.arange(len(run)))
            assert np.array_equal(element["time"], run.table["end_shortening"])
            assert len(element["value"]) == len(run)
        for i in (0, len(run) - 1):
            assert np.array_equal(elements[0]["value"][i], run.positions(i))
            assert np.array_equal(file["observables/drop_center/value"][i], run.drop_center(i))
        for name in run.table.dtype.names:
            assert np.array_equal(
                file[f"observables/{name}/value"], run.table[name], equal_nan=True
            )
        assert file["observables/end_tension/value"].attrs["unit"] == "K0 D-2"
        assert parse_scene(file["parameters/scene"][()].decode()) == run.scene


def test_outputs_are_refused_as_others_are(run, ax, exported):
    with pytest.raises(UsageError, match="is a branch file"):
        export(ax, exported.with_name("ax.h5md"))
    before = exported.read_bytes()
    with pytest.raises(Exception, match="exists"):
        export(run, exported)
    assert exported.read_bytes() == before
    export(run, exported, force=True)


def test_from_the_command_line(run_file, capsys):
    assert main(["export", str(run_file), "-o", str(run_file.with_suffix(".h5md"))]) == 0
    assert capsys.readouterr().out.strip() == str(run_file.with_suffix(".h5md"))


def test_mdanalysis_opens_it(run, exported):
    analysis = pytest.importorskip("MDAnalysis")
    count = run.scene.mesh.edges + 1
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        coil = analysis.Universe.empty(count, trajectory=True)
        coil.load_new(str(exported), convert_units=False)
        assert len(coil.trajectory) == len(run)
        for frame in coil.trajectory:
            i = frame.frame
            assert frame.time == run.table["end_shortening"][i]
            assert frame.data["end_tension"] == run.table["end_tension"][i]
            assert frame.data["drop_center"] == pytest.approx(run.drop_center(i))
            assert coil.atoms.positions == pytest.approx(run.positions(i), abs=1e-6)


def test_the_lines_of_the_page_run(exported, monkeypatch, capsys):
    pytest.importorskip("MDAnalysis")
    (block,) = re.findall(
        r"```python\n(import h5py\nimport MDAnalysis.*?)```", PAGE.read_text(), re.DOTALL
    )
    monkeypatch.chdir(exported.parent)
    exec(block, {})
    assert capsys.readouterr().out
