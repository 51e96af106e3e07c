"""A run file read back whole and held against its checksums."""

from __future__ import annotations

from typing import TYPE_CHECKING

from derod.errors import RecordError
from derod.files.digest import frame_digest, head_digest
from derod.record import layout

if TYPE_CHECKING:
    from derod.record.reader import Run

ARRAYS = tuple(f"{name}/value" for name in layout.ELEMENTS if name != layout.TABLE)
"""What a frame's checksum covers beside its row, in order."""
STEP, TIME = f"{layout.POSITION}/step", f"{layout.POSITION}/time"
HEAD = (
    "h5md",
    "h5md/author",
    "h5md/creator",
    "parameters",
    "particles/rod/box",
    TIME,
    *(f"{name}/value" for name in layout.ELEMENTS),
)
"""The objects whose attributes the head's checksum covers."""


def arrays_of(run: Run) -> tuple[str, ...]:
    """What the checksum of a frame of ``run`` covers beside its row, in order."""
    return (*ARRAYS, f"{layout.EDGE_FRAME}/value") if run.has_edge_frames else ARRAYS


def head_of(run: Run) -> tuple[str, ...]:
    """The objects whose attributes the checksum of the head of ``run`` covers."""
    return (*HEAD, f"{layout.EDGE_FRAME}/value") if run.has_edge_frames else HEAD


def verify_run(run: Run) -> int:
    """Hold all of ``run`` against its checksums; return the number of frames. Raises RecordError."""
    if not run.checksummed:
        raise RecordError(
            f"{run.path}: is not checksummed: it was written by derod 0.1, and whether its values are "
            "as they were written cannot be told"
        )
    verify_head(run)
    whole = whole_frames(run)
    if whole < len(run):
        raise RecordError(
            f"{run.path}: is damaged: increment {whole} of {len(run)} does not fit its checksum; "
            f"the {whole} before it do"
        )
    return whole


def verify_head(run: Run) -> None:
    """Hold everything but the frames against its checksums. Raises RecordError."""
    check = run.attributes_of(("",))[""].get(layout.CHECK)
    if check is None or int(check) != head_digest(run.scene_text, run.attributes_of(head_of(run))):
        raise RecordError(f"{run.path}: is damaged: its head does not fit its checksum")
    _ = run.events, run.extrapolated  # each checked as it is read


def whole_frames(run: Run) -> int:
    """How many frames, from the first, fit their checksums."""
    if not len(run):
        return 0
    table = run.stored_table()
    count = slice(len(run))
    steps, times = run.read_back(count, (STEP, TIME))
    names = arrays_of(run)
    for i in range(len(run)):
        row, time = table[i], float(times[i])
        arrays = run.read_back(i, names)
        fits = int(row[layout.CHECK]) == frame_digest(i, row.tobytes()[:-8], arrays, time)
        if not fits or int(steps[i]) != i:
            return i
    return len(run)
