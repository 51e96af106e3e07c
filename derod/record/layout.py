"""Where things are in a run file: an H5MD-like HDF5 file, one a run.

::

    /h5md                       version, author, creator (H5MD)
    /parameters                 versions and platform as attributes
    /parameters/scene           the effective scene, canonical TOML
    /particles/rod/position/    step (T), time (T), value (T, N+1, 3)
    /particles/rod/arc_length/  step, time, value (T, N+1)
    /particles/rod/edge_tension/ step, time, value (T, N)
    /particles/rod/edge_frame/  step, time, value (T, N, 7), only of sections with directions
    /particles/drop/position/   step, time, value (T, 1, 3)
    /observables/push/          step, time, value (T) of rows.ROW
    /events                     (E) of EVENT_TYPE
    /ending                     (1) of ENDING_TYPE, outcome "" while the push goes on
    /committed                  (2) frames and events that are whole: written last
    /committed_check            (2) checks of the last two such counters: written just before it

``time`` is the value of the control that pushes (its attribute ``quantity``); ``step`` is the increment.
What lies beyond ``committed`` is unfinished and never read.

Everything is checksummed (``derod.files.digest``): a frame, all its arrays included, in the last field of
its row, ``check``; events and the ending likewise; scene, versions and units in the root's attribute
``check``. Format 1, of derod 0.1, had none of these and is still read.
"""

from __future__ import annotations

import numpy as np

from derod.pushing.rows import ALL, ROW

FORMAT = 2
"""Version of this layout; readers refuse a newer one."""
UNCHECKED = 1
"""The last version without checksums."""
CHECK = "check"

H5MD_VERSION = (1, 1)
LIBVER = ("v110", "v110")

SCENE = "parameters/scene"
POSITION = "particles/rod/position"
ARC_LENGTH = "particles/rod/arc_length"
EDGE_TENSION = "particles/rod/edge_tension"
EDGE_FRAME = "particles/rod/edge_frame"
"""Only in runs of sections with directions: what ``Frame.edge_frame`` says."""
DROP = "particles/drop/position"
TABLE = "observables/push"
ELEMENTS = (POSITION, ARC_LENGTH, EDGE_TENSION, DROP, TABLE)
EVENTS = "events"
EXTRAPOLATED = "extrapolated"  # only in runs that were extrapolated, added when they had ended
ENDING = "ending"
COMMITTED = "committed"
COMMITTED_CHECK = "committed_check"

UNITS = {
    POSITION: "D",
    ARC_LENGTH: "D",
    EDGE_TENSION: "K0 D-2",
    EDGE_FRAME: "rad, 1, 1, 1, 1, 1, 1",
    DROP: "D",
}

OLDEST_COLUMNS = {
    "increment": "i8",
    "end_shortening": "f8",
    "end_rotation": "f8",
    "end_tension": "f8",
    "energy_hat": "f8",
    "energy_total": "f8",
    "energy_bend": "f8",
    "energy_twist": "f8",
    "energy_wall": "f8",
    "energy_capillary": "f8",
    "wetted_length": "f8",
    "meniscus_a": "f8",
    "meniscus_b": "f8",
    "force_a": "f8",
    "force_b": "f8",
    "holonomy": "f8",
    "slide_force": "f8",
    "wall_gap": "f8",
    "unstable_modes": "i4",
    "converged": "?",
    "residual": "f8",
    "iterations": "i4",
    "segment": "i4",
    "smooth": "?",
    "landing": "?",
    "next_step": "f8",
    "wall_time": "f8",
}
"""Columns that every run file has; those that ``rows.ROW`` has beyond them may be missing."""

ROW_UNITS = {column.name: column.unit for column in ALL if column.unit}
"""Units of the fields of a row; those not named are counts and flags, or count in the control's."""

ROWS_PER_CHUNK = 32

KIND_BYTES = 32
MESSAGE_BYTES = 1024
# Fixed lengths: variable-length strings cannot be written while others read (SWMR).
EVENT_TYPE = np.dtype(
    [
        ("increment", "i8"),
        ("kind", f"S{KIND_BYTES}"),
        ("end_shortening", "f8"),
        ("energy_before", "f8"),
        ("energy_after", "f8"),
        ("message", f"S{MESSAGE_BYTES}"),
        ("control_value", "f8"),
    ]
)
OLDER_EVENT_TYPE = np.dtype(EVENT_TYPE.descr[:-1])
"""Of runs that only the end-shortening pushed: that was the control's value."""
SHORT_ENDING_TYPE = np.dtype(
    [
        ("outcome", f"S{KIND_BYTES}"),
        ("message", f"S{MESSAGE_BYTES}"),
        ("end_shortening", "f8"),
    ]
)
"""Of files that do not say how long was compiled."""
ENDING_TYPE = np.dtype([*SHORT_ENDING_TYPE.descr, ("compiling", "f8")])


def with_check(dtype: np.dtype) -> np.dtype:
    """The type of a record as it is stored: its fields, then the check."""
    return np.dtype([*dtype.descr, (CHECK, "u8")])


def as_rows(stored: np.ndarray) -> np.ndarray:
    """Stored rows as rows of ``rows.ROW``; numbers of columns they lack are NaN, others zero."""
    if stored.dtype == ROW:
        return stored
    rows = np.zeros(stored.shape, ROW)
    for name in ROW.names or ():
        if name in (stored.dtype.names or ()):
            rows[name] = stored[name]
        elif ROW[name].kind == "f":
            rows[name] = np.nan
    return rows


def has_our_columns(dtype: np.dtype) -> bool:
    """Whether stored rows have the columns of ``rows.ROW`` and no others, so that checks carry over."""
    return tuple(name for name in dtype.names or () if name != CHECK) == ROW.names


STORED_ROW, STORED_EVENT, STORED_ENDING = map(with_check, (ROW, EVENT_TYPE, ENDING_TYPE))
EVENT_TYPES = {
    True: (STORED_EVENT, with_check(OLDER_EVENT_TYPE)),
    False: (OLDER_EVENT_TYPE,),
}
"""What events may be stored as, with checksums and without."""


ENDING_TYPES = {
    True: (STORED_ENDING, with_check(SHORT_ENDING_TYPE)),
    False: (ENDING_TYPE, SHORT_ENDING_TYPE),
}
"""Types that an ending may have, with its check and without."""


def record(dtype: np.dtype, values: tuple[object, ...]) -> np.void:
    """One record of a structured type."""
    made = np.zeros(1, dtype)
    made[0] = values
    return made[0]


def encoded(text: str, size: int) -> bytes:
    """``text`` as UTF-8 of at most ``size`` bytes, cut between characters."""
    return text.encode("utf-8", "replace")[:size].decode("utf-8", "ignore").encode("utf-8")


def decoded(value: bytes) -> str:
    """The text that ``encoded`` stored."""
    return value.decode("utf-8", "replace")
