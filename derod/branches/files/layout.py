"""The layout of a branch file (HDF5): one group a branch, everything needed to draw it, compare with
it, restart from it.

Attributes ``format``, ``parameters`` (one dataset of the dimensionless numbers),
``scene`` (its text); ``branches/NAME`` with ``table`` (one row a point), ``nodes`` and ``eta``
(the half rod's node states and element lengths of all points, one after another) and
``bifurcations``. ``check`` is the checksum of a group, and at the root of all but the groups. Every branch
is written as it is done, in one step; the attribute ``complete`` is true when all that were asked for are
there. Files of derod 0.1 (format 1) have neither. Files before format 3 have no ``weight`` among the
parameters, those before format 4 no ``bending_2`` and ``director``: rods had one bending stiffness.
"""

from __future__ import annotations

import numpy as np

OLD_FORMAT = "derod-branches-1"
FORMATS = (OLD_FORMAT, "derod-branches-2", "derod-branches-3", "derod-branches-4")
FORMAT = FORMATS[-1]
"""What is written."""
SINCE = {"weight": FORMATS[2], "bending_2": FORMATS[3], "director": FORMATS[3]}
"""The first format that has a parameter; in older files it is what ``Parameters`` has by itself."""
POINT = np.dtype(
    [
        ("end_shortening", "f8"),  # delta, D
        ("end_tension", "f8"),  # t, K0/D^2
        ("energy_hat", "f8"),  # E_tot + f_gamma (delta + 1), K0/D
        ("energy_total", "f8"),
        ("energy_bend", "f8"),
        ("energy_twist", "f8"),
        ("energy_wall", "f8"),
        ("wetted_length", "f8"),  # 2 sigma, D
        ("meniscus_force", "f8"),  # f_B, K0/D^2
        ("drop_y", "f8"),  # y_C from the clamp axis, D
        ("wall_gap", "f8"),  # least 1 + rho - 2 r
        ("error", "f8"),  # mesh halving: t, E_hat (relative), wetted length
        ("unstable_modes", "i4"),  # -1: not counted
        ("elements", "i4"),
        ("inner", "i4"),  # of them in the drop
        ("scalars", "f8", (6,)),  # c_x, c_z, u3, sigma, delta, f_gamma
    ]
)
"""One row of a branch's table."""

BIFURCATION = np.dtype(
    [
        ("kind", "S16"),
        ("index", "i8"),  # row of the table
        ("end_shortening", "f8"),
        ("end_tension", "f8"),
        ("energy_hat", "f8"),
        ("partner", "S32"),  # the branch that joins here, "" where none was followed
        ("test_function", "f8"),  # what is left of it, relative to its bracket
    ]
)
