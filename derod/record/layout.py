"""Where things are in a run file: an H5MD-like HDF5 file, one a run.

::

    /h5md                       version, author, creator (H5MD)
    /parameters                 versions and platform as attributes
    /parameters/scene           the effective scene, canonical TOML
    /particles/rod/position/    step (T), time (T), value (T, N+1, 3)
    /particles/rod/arc_length/  step, time, value (T, N+1)
    /particles/rod/edge_tension/ step, time, value (T, N)
    /particles/drop/position/   step, time, value (T, 1, 3)
    /observables/push/          step, time, value (T) of frames.ROW
    /events                     (E) of EVENT_TYPE
    /ending                     (1) of ENDING_TYPE, outcome "" while the push goes on
    /committed                  (2) frames and events that are whole: written last

``time`` is the end-shortening (D), which drives the quasi-static push; ``step`` is the increment.
What lies beyond ``committed`` is unfinished and never read.
"""

from __future__ import annotations

import numpy as np

FORMAT = 1
"""Version of this layout; readers refuse a newer one."""

H5MD_VERSION = (1, 1)
LIBVER = ("v110", "v110")

SCENE = "parameters/scene"
POSITION = "particles/rod/position"
ARC_LENGTH = "particles/rod/arc_length"
EDGE_TENSION = "particles/rod/edge_tension"
DROP = "particles/drop/position"
TABLE = "observables/push"
ELEMENTS = (POSITION, ARC_LENGTH, EDGE_TENSION, DROP, TABLE)
EVENTS = "events"
EXTRAPOLATED = "extrapolated"  # only in runs that were extrapolated, added when they had ended
ENDING = "ending"
COMMITTED = "committed"

UNITS = {
    POSITION: "D",
    ARC_LENGTH: "D",
    EDGE_TENSION: "K0 D-2",
    DROP: "D",
}

ROW_UNITS = {
    "end_shortening": "D",
    "end_rotation": "rad",
    "end_tension": "K0 D-2",
    "energy_hat": "K0 D-1",
    "energy_total": "K0 D-1",
    "energy_bend": "K0 D-1",
    "energy_twist": "K0 D-1",
    "energy_wall": "K0 D-1",
    "energy_capillary": "K0 D-1",
    "wetted_length": "D",
    "meniscus_a": "D",
    "meniscus_b": "D",
    "force_a": "K0 D-2",
    "force_b": "K0 D-2",
    "holonomy": "rad",
    "slide_force": "K0 D-2",
    "wall_gap": "D",
    "residual": "K0 D-2",
    "work_defect": "K0 D-1",
    "turning_angle": "rad",
    "next_step": "D",
    "wall_time": "s",
}
"""Units of the fields of a row; those not named are counts and flags."""

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
    ]
)
ENDING_TYPE = np.dtype(
    [
        ("outcome", f"S{KIND_BYTES}"),
        ("message", f"S{MESSAGE_BYTES}"),
        ("end_shortening", "f8"),
    ]
)


def encoded(text: str, size: int) -> bytes:
    """``text`` as UTF-8 of at most ``size`` bytes, cut between characters."""
    return text.encode("utf-8", "replace")[:size].decode("utf-8", "ignore").encode("utf-8")


def decoded(value: bytes) -> str:
    """The text that ``encoded`` stored."""
    return value.decode("utf-8", "replace")
