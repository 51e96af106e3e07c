"""VTK's XML files, written by hand: PolyData (.vtp) with inline base64 arrays, and collections (.pvd).

An array is its number of bytes (UInt64) and its bytes, both little-endian, in base64. Units are kept as
VTK's own information key UNITS_LABEL, which must follow the data: VTK reads these from the opening tag on.
"""

from __future__ import annotations

import base64
from collections.abc import Mapping, Sequence
from typing import NamedTuple
from xml.sax.saxutils import quoteattr

import numpy as np

TYPES = {
    "f4": "Float32", "f8": "Float64", "i4": "Int32", "i8": "Int64", "u1": "UInt8", "u4": "UInt32",
}  # fmt: skip
HEAD = '<?xml version="1.0"?>\n'


class Field(NamedTuple):
    """An array with a row a point, (k,) or (k, c), and its unit ("" if it has none)."""

    values: np.ndarray
    unit: str = ""


def data_array(name: str, field: Field, tuples: bool = False) -> str:
    """A DataArray element; ``tuples``: say how many rows it has, as FieldData wants it."""
    values = np.ascontiguousarray(field.values)
    values = values.astype(values.dtype.newbyteorder("<"), copy=False)
    kind = TYPES[values.dtype.str[1:]]
    raw = values.tobytes()
    packed = base64.b64encode(len(raw).to_bytes(8, "little") + raw).decode("ascii")
    parts = values.shape[1] if values.ndim == 2 else 1
    shape = f' NumberOfComponents="{parts}"' + (
        f' NumberOfTuples="{len(values)}"' if tuples else ""
    )
    unit = (
        f'<InformationKey name="UNITS_LABEL" location="vtkDataArray">{field.unit}</InformationKey>'
        if field.unit
        else ""
    )
    head = f'<DataArray type="{kind}" Name={quoteattr(name)}{shape} format="binary">'
    return f"{head}{packed}{unit}</DataArray>"


def poly_data(
    points: np.ndarray,
    cells: Sequence[np.ndarray],
    sort: str,
    point_data: Mapping[str, Field] | None = None,
    field_data: Mapping[str, Field] | None = None,
) -> bytes:
    """A PolyData file: ``points`` (k, 3), and ``cells`` of point numbers, all of one ``sort``.

    ``sort``: "Lines" (each a polyline) or "Polys" (each a polygon).
    """
    counts = {
        kind: len(cells) if kind == sort else 0 for kind in ("Verts", "Lines", "Strips", "Polys")
    }
    numbers = " ".join(f'NumberOf{kind}="{count}"' for kind, count in counts.items())
    connectivity = np.concatenate(list(cells)).astype("<i8")
    offsets = np.cumsum([len(cell) for cell in cells]).astype("<i8")
    fields = [data_array(name, field, tuples=True) for name, field in (field_data or {}).items()]
    lines = [
        f'{HEAD}<VTKFile type="PolyData" version="1.0" byte_order="LittleEndian" header_type="UInt64">',
        "<PolyData>",
        *(["<FieldData>", *fields, "</FieldData>"] if fields else []),
        f'<Piece NumberOfPoints="{len(points)}" {numbers}>',
        "<PointData>",
        *(data_array(name, field) for name, field in (point_data or {}).items()),
        "</PointData>",
        "<Points>",
        data_array("Points", Field(points)),
        "</Points>",
        f"<{sort}>",
        data_array("connectivity", Field(connectivity)),
        data_array("offsets", Field(offsets)),
        f"</{sort}>",
        "</Piece>",
        "</PolyData>",
        "</VTKFile>",
    ]
    return ("\n".join(lines) + "\n").encode("ascii")


def collection(items: Sequence[tuple[float, int, str, str]]) -> bytes:
    """A .pvd file of (time, part, name of the part, file) items."""
    lines = [
        f'{HEAD}<VTKFile type="Collection" version="0.1" byte_order="LittleEndian">',
        "<Collection>",
        *(
            f'<DataSet timestep="{time!r}" group="" part="{part}" name={quoteattr(name)} '
            f"file={quoteattr(file)}/>"
            for time, part, name, file in items
        ),
        "</Collection>",
        "</VTKFile>",
    ]
    return ("\n".join(lines) + "\n").encode("utf-8")
