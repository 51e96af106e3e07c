"""The layout of a diagram file (HDF5): one group a path, everything needed to draw it and to go on from it.

At the root the attributes ``format``, ``scene`` (its text), ``control``, ``command`` (what was asked for,
JSON), ``stages`` (of an exploration, done) and ``complete``; ``paths/NAME`` with ``table`` (a row a point:
the columns of a run's table, then those below), the fields of a run's frames, and ``specials``. ``check``
is the checksum of a group, and at the root of all but the groups. Units are those of runs: D, K0/D^2,
K0/D, radians.
"""

from __future__ import annotations

import numpy as np

from derod.pushing.rows import ROW

FORMAT = "derod-diagram-1"
TABLE, SPECIALS, FRAMES = (
    "table",
    "specials",
    ("positions", "arc_length", "edge_tension", "drop_center"),
)
TEXTS = ("begins", "ends", "character")

POINT = np.dtype(
    [
        *((name, ROW[name]) for name in ROW.names or ()),
        ("path_arc", "f8"),  # s along the path, D
        ("path_rate", "f8"),  # of the control by s, in the control's unit over D
    ]
)
"""One row of a path's table; ``iterations`` are those of the step's correction."""

SPECIAL = np.dtype(
    [
        ("kind", "S16"),  # fold, branch point, joint
        ("index", "i8"),  # the row before it; the last row for one behind the end
        ("path_arc", "f8"),
        ("value", "f8"),  # of the control, in its unit
        ("end_shortening", "f8"),
        ("end_tension", "f8"),
        ("energy_hat", "f8"),
        ("change", "i4"),  # of the unstable modes, along the path
        ("eigenvalue", "f8"),  # left at the nearest settled point, K0/D^4
        ("error", "f8"),  # of the control, estimated
        ("symmetric", "?"),  # a pitchfork; else transcritical
        ("fate", "S32"),  # what came of switching there
        ("partner", "S32"),  # the path that meets this one there
    ]
)
