"""What is exported, read back: CSV against the table, VTK against positions and fields."""

from __future__ import annotations

import base64
import csv
import xml.etree.ElementTree as ET

import numpy as np
import pytest

from derod.cli import main
from derod.errors import DerodError
from derod.views.export import export

TYPES = {"Float32": "<f4", "Float64": "<f8", "Int32": "<i4", "Int64": "<i8", "UInt8": "u1"}


def read_table(path):
    with path.open(encoding="utf-8", newline="") as file:
        head, *rows = csv.reader(file)
    return head, rows


def array(element):
    """A DataArray: the bytes' number, the bytes, in base64, straight after the opening tag."""
    raw = base64.b64decode(element.text, validate=True)
    assert int.from_bytes(raw[:8], "little") == len(raw) - 8
    values = np.frombuffer(raw[8:], TYPES[element.get("type")])
    parts = int(element.get("NumberOfComponents"))
    return values.reshape(-1, parts) if parts > 1 else values


def read_vtp(path):
    """Points, (connectivity, offsets) of its lines or polygons, fields at points, field data, units."""
    root = ET.parse(path).getroot()
    assert (root.get("type"), root.get("header_type")) == ("PolyData", "UInt64")
    piece = root.find("PolyData/Piece")
    sort = "Lines" if piece.get("NumberOfLines") != "0" else "Polys"
    cells = {part.get("Name"): array(part) for part in piece.find(sort)}
    assert len(cells["offsets"]) == int(piece.get(f"NumberOf{sort}"))
    points = array(piece.find("Points/DataArray"))
    assert len(points) == int(piece.get("NumberOfPoints"))
    found = {part.get("Name"): array(part) for part in piece.find("PointData")}
    fields = {
        part.get("Name"): array(part)[0]
        for part in root.iter("DataArray")
        if part.get("NumberOfTuples")
    }
    units = {
        part.get("Name"): part.find("InformationKey").text
        for part in root.iter("DataArray")
        if part.find("InformationKey") is not None
    }
    return points, cells, found, fields, units


def test_csv_of_a_run_reads_back_exactly(run_file, run, capsys):
    out = run_file.with_name("rows.csv")
    assert main(["export", str(run_file), "-o", str(out)]) == 0
    assert capsys.readouterr().out.strip() == str(out)
    head, rows = read_table(out)
    assert len(rows) == len(run)
    names = [title.split(" [")[0] for title in head]
    assert names == list(run.table.dtype.names)
    for k, name in enumerate(names):
        column = np.array([float(row[k]) for row in rows])
        assert np.array_equal(column, run.table[name].astype(float), equal_nan=True)
    titles = dict(zip(names, head, strict=True))
    assert titles["end_tension"] == "end_tension [K0 D-2]"
    assert titles["end_rotation"] == "end_rotation [rad]"
    assert titles["unstable_modes"] == "unstable_modes"


def test_every_number_with_a_dimension_has_its_unit():
    from derod.branches.files.layout import POINT
    from derod.pushing.rows import ROW
    from derod.record.layout import ROW_UNITS
    from derod.views.export.table import LEFT_OUT, POINT_UNITS

    for dtype, units in ((ROW, ROW_UNITS), (POINT, POINT_UNITS)):
        floats = {name for name in dtype.names if dtype[name].kind == "f"} - set(LEFT_OUT)
        assert floats - {"next_step"} <= set(units)  # its unit is the control's


def test_csv_of_branches(ax, tmp_path):
    out = tmp_path / "b.csv"
    assert export(ax, out) == [out]
    head, rows = read_table(out)
    table = ax["Ax"].table
    assert head[:3] == ["branch", "special", "end_shortening [D]"]
    assert len(rows) == len(table)
    tension = [float(row[head.index("end_tension [K0 D-2]")]) for row in rows]
    assert np.array_equal(tension, table["end_tension"])
    special = ax["Ax"].bifurcations
    kinds = {i: row[1] for i, row in enumerate(rows) if row[1]}
    assert kinds == {int(s["index"]): s["kind"].decode() for s in special}
    assert {row[0] for row in rows} == {"Ax"}


def test_vtk_frames_hold_the_rod(run_file, run, capsys):
    out = run_file.with_name("coil.pvd")
    assert main(["export", str(run_file), "-o", str(out)]) == 0
    assert "coil.pvd, and 60 files in" in capsys.readouterr().out
    root = ET.parse(out).getroot()
    assert root.get("type") == "Collection"
    sets = root.findall("Collection/DataSet")
    rods = [part for part in sets if part.get("name") == "rod"]
    assert [float(part.get("timestep")) for part in rods] == run.table["end_shortening"].tolist()
    for i in (0, 12, 29):
        points, cells, found, fields, units = read_vtp(out.parent / rods[i].get("file"))
        assert np.array_equal(points, run.positions(i))
        assert cells["connectivity"].tolist() == list(range(81)) and cells["offsets"].tolist() == [
            81
        ]
        assert np.array_equal(found["arc_length"], run.arc_length(i))
        ends = np.array([[0, 0, 1]])
        edges = np.diff(points, axis=0)
        edges = np.vstack([ends, edges / np.linalg.norm(edges, axis=1)[:, None], ends])
        mean = edges[1:] + edges[:-1]
        assert found["tangent"] == pytest.approx(mean / np.linalg.norm(mean, axis=1)[:, None])
        turning = np.arccos(np.clip(np.sum(edges[1:] * edges[:-1], axis=1), -1, 1))
        assert found["curvature"][1:-1] == pytest.approx(turning[1:-1] / 0.125, abs=1e-5)
        tension = run.edge_tension(i)
        assert found["tension"][1:-1] == pytest.approx((tension[1:] + tension[:-1]) / 2)
        across = np.sum(found["director_1"] * found["tangent"], axis=1)
        assert across == pytest.approx(np.zeros(81), abs=1e-12)
        row = run.table[i]
        inside = (run.arc_length(i) >= row["meniscus_a"]) & (run.arc_length(i) <= row["meniscus_b"])
        assert abs(int(found["wetted"].sum()) - inside.sum()) <= 2  # the menisci count
        assert fields["end_tension"] == row["end_tension"] and fields["increment"] == i
        assert units["curvature"] == "1/D" and units["tension"] == "K0/D^2"


def test_vtk_frames_hold_the_drop(run, tmp_path):
    files = export(run, tmp_path / "coil.pvd")
    drops = [path for path in files if path.name.startswith("drop")]
    assert len(drops) == 30
    points, cells, *_ = read_vtp(drops[7])
    assert np.linalg.norm(points - run.drop_center(7), axis=1) == pytest.approx(0.5, rel=1e-5)
    assert cells["connectivity"].max() < len(points)
    assert (np.diff(cells["offsets"]) == 3).all()


def test_a_push_that_turns_back_has_increments_for_times(run):
    from derod.views.export.series import times

    table = run.table.copy()
    table["end_shortening"][20:] = table["end_shortening"][19:9:-1]
    run._table = table
    assert times(run) == list(range(30))


def test_refusals_leave_everything_as_it_was(run, ax, tmp_path):
    out = tmp_path / "coil.pvd"
    export(run, out)
    frame = tmp_path / "coil" / "rod_00000.vtp"
    stale = tmp_path / "coil" / "rod_99999.vtp"
    stale.write_text("of a longer run")
    frame.write_text("mine")
    with pytest.raises(DerodError, match="exists already; --force replaces it"):
        export(run, out)
    out.unlink()
    with pytest.raises(DerodError, match=r"its folder .*coil exists"):
        export(run, out)
    assert frame.read_text() == "mine" and not out.exists()
    export(run, out, force=True)
    assert frame.stat().st_size > 1000 and not stale.exists()
    notes = tmp_path / "coil" / "notes.txt"
    notes.write_text("not ours")
    with pytest.raises(DerodError, match=r"holds other things than \.vtp files"):
        export(run, out, force=True)
    assert notes.read_text() == "not ours"
    with pytest.raises(DerodError, match="is a branch file"):
        export(ax, tmp_path / "b.pvd")
    with pytest.raises(DerodError, match=r"ends in \.csv or \.pvd"):
        export(run, tmp_path / "b.vtk")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["coil", "coil.pvd"]


@pytest.mark.parametrize("force", [True, False])
def test_a_file_is_whole_or_absent(tmp_path, monkeypatch, force):
    from pathlib import Path

    from derod.views.export.output import write_file

    out = tmp_path / "a.csv"
    write = Path.write_bytes

    def fails(path, data):
        write(path, data[:3])
        raise OSError(28, "No space left on device")

    if force:
        out.write_bytes(b"before")
    monkeypatch.setattr(Path, "write_bytes", fails)
    with pytest.raises(DerodError, match="cannot be written: no space left"):
        write_file(out, b"123456", force)
    assert [path.name for path in tmp_path.iterdir()] == (["a.csv"] if force else [])
    assert not force or out.read_bytes() == b"before"


def test_a_file_that_came_in_between_is_kept(tmp_path):
    from derod.views.export.output import write_file

    out = tmp_path / "a.csv"
    out.write_bytes(b"another's")
    with pytest.raises(DerodError, match="exists"):
        write_file(out, b"mine", force=False)
    assert out.read_bytes() == b"another's"
    assert [path.name for path in tmp_path.iterdir()] == ["a.csv"]
