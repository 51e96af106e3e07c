"""Runs as a notebook reads them: indices, places, columns, tables, faces."""

from __future__ import annotations

import io
import math
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import derod
from derod.needs import MissingError
from derod.pushing.rows import ROW
from derod.record import BaseRun, MemoryRun, RunWriter
from derod.views.branch_faces import Branches
from derod.views.progress import Progress
from tests.scenes import coil
from tests.synthetic import drive, small_scene


def test_increments(run: BaseRun) -> None:
    last = run[-1]
    assert last.index == len(run) - 1 and run[len(run) - 1].row == last.row
    assert last.end_tension == run.table["end_tension"][-1] and isinstance(last.end_tension, float)
    assert last.converged is True
    for name in ("positions", "arc_length", "edge_tension", "drop_center", "curvature", "moment"):
        assert np.array_equal(getattr(last, name), getattr(run, name)(-1))
    assert np.array_equal(last.frame.positions, last.positions)
    assert np.array_equal(last.wall_pressure, run.wall_pressure(-1))
    assert np.array_equal(last.directors.d1, run.directors(-1).d1)
    assert last.modes(1).eigenvalues == pytest.approx(run.modes(-1, 1).eigenvalues)
    assert [one.index for one in run[2:8:2]] == [2, 4, 6]
    assert [one.index for one in run] == list(range(len(run)))
    assert np.array_equal(run["energy_hat"], run.table["energy_hat"])
    assert {"end_tension", "positions"} <= set(dir(last))
    for wrong in (len(run), -len(run) - 1):
        with pytest.raises(IndexError, match=f"increment {wrong} of a run with"):
            run[wrong]
    with pytest.raises(KeyError, match="no column 'tension'; allowed: increment, end_short"):
        run["tension"]
    with pytest.raises(AttributeError, match="no 'tension'; its row has increment"):
        _ = last.tension


def test_places(run: BaseRun) -> None:
    assert run.at("0.3 pi").end_shortening == 0.3 * math.pi and run.at("0.3 pi").landing
    assert run.at(0.3 * math.pi).index == run.at("0.3 pi").index
    assert run.at(run[5].end_shortening + 1e-6).index == 5
    with pytest.raises(ValueError, match=r"at '0.3 p': is not understood.*or '0.5 pi'"):
        run.at("0.3 p")
    with pytest.raises(
        IndexError, match=r"at 3.14159 D \(1 pi\): the run was not there; allowed: 0.00314159 D"
    ):
        run.at("pi")
    empty = MemoryRun()
    empty.start(run.scene, 0)
    with pytest.raises(IndexError, match=r"at 1 D \(0.31831 pi\): the run has no increment"):
        empty.at(1.0)


def test_where_a_push_turns_back_the_first_is_meant() -> None:
    run = derod.push(coil(stop='["0.1 pi", "0.05 pi"]', at='["0.08 pi"]'))
    here = np.flatnonzero(run["end_shortening"] == 0.08 * math.pi)
    assert len(here) == 2 and run.at("0.08 pi").index == here[0]


def test_pandas_and_xarray(run: BaseRun) -> None:
    pytest.importorskip("pandas")
    table = run.to_pandas()
    assert list(table.columns) == list(ROW.names or ())[1:] and len(table) == len(run)
    assert np.array_equal(table["end_tension"], run["end_tension"])
    assert table.attrs["units"]["end_tension"] == "K0 D-2"
    pytest.importorskip("xarray")
    data = run.to_xarray()
    assert np.array_equal(data["positions"].values[7], run.positions(7))
    assert np.array_equal(data["curvature"].sel(increment=7), run.curvature(7))
    assert data["edge_tension"].attrs["units"] == "K0 D-2"
    assert derod.parse_scene(data.attrs["scene"]) == run.scene


@pytest.mark.parametrize("package", ["pandas", "xarray"])
def test_a_missing_package_is_named(
    run: BaseRun, package: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, package, None)
    with pytest.raises(MissingError, match=f"needs {package}, which is not installed: pip install"):
        getattr(run, f"to_{package}")()


def test_faces_of_runs(run: BaseRun, tmp_path: Path) -> None:
    pytest.importorskip("matplotlib")
    assert repr(run) == (
        f"<run in memory: {len(run)} increments, "
        "completed: reached end-shortening 1.5708 D (0.5 pi)>"
    )
    assert "0.942478 D (0.3 pi)" in repr(run.at("0.3 pi")) and "stable>" in repr(run[-1])
    html = run._repr_html_()
    assert "data:image/png;base64," in html and "0.942478 D (0.3 pi)" in html
    assert "<td style='text-align:left'>end_tension</td>" in run[-1]._repr_html_()
    drive(small_scene(), [RunWriter(tmp_path / "a<b.h5")])
    opened = derod.open_run(tmp_path / "a<b.h5")
    assert "a&lt;b.h5" in opened._repr_html_()
    opened.close()
    assert f"{len(opened)} increments" in repr(opened) or "a<b.h5" in repr(opened)
    empty = MemoryRun()
    empty.start(run.scene, 0)
    assert repr(empty) == "<run in memory: 0 increments, running, or killed>"
    assert "0 increments" in empty._repr_html_()
    assert "has not begun" in repr(MemoryRun()) and "has not begun" in MemoryRun()._repr_html_()


def test_a_face_without_matplotlib_says_so(run: BaseRun, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    html = run._repr_html_()
    assert "no picture: a picture needs matplotlib" in html and "0.942478 D" in html


def test_push_takes_names_and_files(tmp_path: Path) -> None:
    short = derod.Scene("quick", {"push.stop": "0.01 pi", "mesh.edges": 40})
    file = tmp_path / "short.toml"
    file.write_text(short.text)
    for scene in (file, str(file), short):
        assert derod.push(scene).scene == short
    with pytest.raises(derod.SceneError, match=r"allowed: a file's path, or quick"):
        derod.push("quik")


def test_progress_in_any_place(capsys: pytest.CaptureFixture[str]) -> None:
    derod.push(coil(stop='"0.05 pi"'), progress=True)
    error = capsys.readouterr().err
    assert "100%|" in error and "0.1571 D (0.05 pi) of 0.1571 D (0.05 pi)" in error
    stream = io.StringIO()
    drive(small_scene(), [Progress(stream, everywhere=True)])
    assert "100%|" in stream.getvalue()


def test_branches_and_comparison(tmp_path: Path) -> None:
    pytest.importorskip("matplotlib")
    scene = coil(edges=100, stop='"0.15 pi"')
    path = tmp_path / "ax.h5"
    file = derod.branch(scene, path, paths="Ax", max_step=0.5, stability=False)
    assert isinstance(file, Branches) and repr(file) == f"<branches {path}: Ax>"
    html = file._repr_html_()
    assert "data:image/png;base64," in html and "pitchfork" not in html
    run = derod.push(scene, tmp_path / "run.h5")
    found = derod.compare(run, file, 3)
    assert found.on_branches == len(found) == len(range(0, len(run), 3))
    assert not found.exceeds(1e-3) and found.exceeds(1e-9)
    assert found.worst["tension_error"][0] < 1e-4
    assert "rows on a branch; worst tension_error" in repr(found) and "worst" in str(found)
    assert "<td style='text-align:left'>shape_error</td>" in found._repr_html_()
    again = derod.compare(tmp_path / "run.h5", path, 3)
    assert np.array_equal(again.table, found.table)
    with derod.open_branches(path) as opened:
        assert repr(opened) == repr(file)
    with pytest.raises(derod.RecordError, match="exists already"):
        derod.branch(scene, path, paths="Ax")
    for options, words in (
        ({"paths": "Bx"}, "no such path"),
        ({"tolerance": 2.0}, "tolerance = 2.0 is out of range; allowed: between 0 and 1"),
    ):
        with pytest.raises(derod.SceneError, match=words):
            derod.branch(scene, **options)
    with pytest.raises(derod.SceneError, match="every = 0"):
        derod.compare(run, file, 0)


def test_branches_in_memory_and_paths_that_are_not_met() -> None:
    from derod.branch_api import BranchWarning

    with pytest.warns(BranchWarning, match="L7: not met"):
        file = derod.branch(
            coil(), paths=["Ax", "L7"], max_step=0.5, accuracy=1e-5, stability=False
        )
    assert file.names == ["Ax"] and not Path(file.path).exists()
    assert file["Ax"].positions(3).shape[1] == 3 and repr(file).startswith(
        "<branches in memory: Ax"
    )


def test_a_reader_of_runs_gets_no_kernels(tmp_path: Path) -> None:
    file = tmp_path / "run.h5"
    drive(small_scene(), [RunWriter(file)])
    code = (
        f"import sys, derod\nrun = derod.open_run({str(file)!r})\nrepr(run), run[-1], repr(run[-1]), "
        "run.directors(-1), run.curvature(0), derod.Scene('quick')\n"
        "print([m for m in ('numba', 'matplotlib', 'rerun') if m in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert done.stdout == "[]\n", done.stderr + done.stdout
