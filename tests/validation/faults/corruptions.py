"""Files with a flipped bit or without an end: no wrong value with verification, no hang, no traceback."""

from __future__ import annotations

import os
import random
import time
from collections.abc import Callable
from pathlib import Path

import h5py
import numpy as np

from derod.branches.paths.branch import Bifurcation, Branch
from derod.errors import DerodError, RecordError
from derod.pushing.frames import Ending, Outcome
from derod.record import RunWriter, open_run, resume_copy
from tests.synthetic import drive, is_frame, make_event, make_frame, small_scene
from tests.validation.faults.trial import Found

COUNT = 40
SLOWEST = 5.0  # s
HEAD_BYTES = 20_000
"""Nearly all of HDF5's own blocks lie there: half of the flips do too."""
GOOD = "read as written"


def finished(folder: Path) -> bytes:
    """A finished run."""
    path = folder / "finished.h5"
    drive(small_scene(), [RunWriter(path)])
    return path.read_bytes()


def killed(folder: Path) -> bytes:
    """A run as a killed writer leaves it."""
    path = folder / "killed.h5"
    writer = RunWriter(path)
    writer.start(small_scene(), 0)
    for i in range(COUNT):
        if i % 5 == 4:
            writer.event(make_event(i))
        writer.frame(make_frame(i, 24))
    data = path.read_bytes()
    writer.finish(Ending(Outcome.INTERRUPTED, "", 0.0))
    return data


def look(path: Path) -> str:
    """Open a run with verification and hold all of it against what was written."""
    try:
        with open_run(path, verify=True) as run:
            same = len(run) == COUNT and run.scene == small_scene()
            same = same and all(is_frame(run, i) for i in range(COUNT))
            same = same and list(run.events) == [make_event(i) for i in range(4, COUNT, 5)]
            return GOOD if same else "wrong"
    except DerodError as error:
        return "refused" if str(error).isprintable() else "refused in more than a line"


def judged(found: Found, what: str, trial: Callable[[], str]) -> None:
    """Run a trial: anything but a right answer or a refusal, or a slow one, is a failure."""
    began = time.monotonic()
    try:
        outcome = trial()
    except Exception as error:
        outcome = f"traceback of {type(error).__name__}"
    seconds = time.monotonic() - began
    found.add(outcome, seconds)
    if outcome not in (GOOD, "refused") or seconds > SLOWEST:
        found.fail(f"{what}: {outcome} in {seconds:.1f} s")


def flipped(data: bytes, chance: random.Random) -> tuple[int, bytes]:
    """Data with a bit flipped, in the head in half of all cases."""
    size = HEAD_BYTES if chance.random() < 0.5 else len(data)
    place = chance.randrange(min(size, len(data)))
    return place, data[:place] + bytes([data[place] ^ 1 << chance.randrange(8)]) + data[place + 1 :]


def _flips(folder: Path, trials: int, what: str, data: bytes, seed: int) -> Found:
    found, chance = Found(f"bit flips of {what}"), random.Random(seed)
    path = folder / "flipped.h5"
    for _ in range(trials):
        place, changed = flipped(data, chance)
        path.write_bytes(changed)
        judged(found, f"{what}, byte {place}", lambda: look(path))
    return found


def flips_of_finished(folder: Path, trials: int) -> Found:
    """Of a finished run."""
    return _flips(folder, trials, "finished runs", finished(folder), 11)


def flips_of_killed(folder: Path, trials: int) -> Found:
    """Of a killed run."""
    return _flips(folder, trials, "killed runs", killed(folder), 12)


def flips_of_live(folder: Path, trials: int) -> Found:
    """In the file itself while its writer has it open, and reads on."""
    found, chance = Found("bit flips of runs that are written"), random.Random(13)
    for number in range(trials):
        path = folder / f"live-{number}.h5"
        writer = RunWriter(path)
        writer.start(small_scene(), 0)
        for i in range(COUNT):
            if i % 5 == 4:
                writer.event(make_event(i))
            writer.frame(make_frame(i, 24))
        place = chance.randrange(path.stat().st_size)
        descriptor = os.open(path, os.O_RDWR)
        byte = os.pread(descriptor, 1, place)[0] ^ 1 << chance.randrange(8)
        os.pwrite(descriptor, bytes([byte]), place)
        os.close(descriptor)
        judged(found, f"live, byte {place}", lambda path=path: look(path))
        writer.finish(Ending(Outcome.INTERRUPTED, "", 0.0))
        path.unlink()
    return found


def branch_file(folder: Path) -> bytes:
    """A branch file of one path, the straight rod and what leaves it."""
    from derod.branches.files.writing import write_branches
    from derod.branches.half_rod.parameters import Parameters
    from derod.branches.paths.arc import Control
    from derod.branches.paths.catalogue import Catalogue

    parameters = Parameters(wall_strength=2e-2)
    catalogue = Catalogue(parameters, Control(largest_step=0.5))
    branch: Branch = catalogue.store(catalogue.ax(), False)
    branch.points, branch.bifurcations = branch.points[:6], [Bifurcation(1, "fold", "", 0.0)]
    path = folder / "branches.h5"
    write_branches(path, parameters, [branch], "text")
    return path.read_bytes()


def branch_values(path: Path) -> list[object]:
    """All that a branch file holds."""
    from derod.branches.files.record import open_branches

    with open_branches(path) as file:
        return [
            file.parameters,
            file.scene_text,
            *(
                (
                    name,
                    branch.table.tobytes(),
                    branch.bifurcations.tobytes(),
                    [branch.positions(i).tobytes() for i in range(len(branch))],
                    (branch.begins, branch.ends, branch.mirror, branch.remarks),
                )
                for name, branch in file.items()
            ),
        ]


def flips_of_branches(folder: Path, trials: int) -> Found:
    """Of branch files, which are always held against their checksums."""
    data, chance = branch_file(folder), random.Random(14)
    path = folder / "branches.h5"
    right = branch_values(path)
    found = Found("bit flips and cuts of branch files")

    def trial() -> str:
        try:
            return GOOD if branch_values(path) == right else "wrong"
        except DerodError as error:
            return "refused" if str(error).isprintable() else "refused in more than a line"

    for number in range(trials):
        place, changed = flipped(data, chance)
        if number % 5 == 4:
            changed = data[:place]
        path.write_bytes(changed)
        judged(found, f"branches, byte {place}", trial)
    return found


def borders(path: Path) -> list[int]:
    """Where the blocks of a file's datasets begin and end."""
    places = set()

    def visit(_: str, item: object) -> None:
        if not isinstance(item, h5py.Dataset):
            return
        if item.chunks is None:
            begin = item.id.get_offset()
            if begin is not None:
                places.update((begin, begin + item.id.get_storage_size()))
            return
        for i in range(item.id.get_num_chunks()):
            chunk = item.id.get_chunk_info(i)
            places.update((chunk.byte_offset, chunk.byte_offset + chunk.size))

    with h5py.File(path) as file:
        file.visititems(visit)
    return sorted(places)


def cuts(folder: Path, trials: int) -> Found:
    """At every border of a chunk, beside it, and anywhere: of finished and of killed runs."""
    found, chance = Found("cuts at the borders of all chunks, and anywhere"), random.Random(15)
    whole = {"finished": finished(folder), "killed": killed(folder)}
    at = borders(folder / "finished.h5")
    path = folder / "cut.h5"
    for number in range(trials):
        kind = ("finished", "killed")[number % 2]
        data = whole[kind]
        size = at[number // 2 % len(at)] + chance.choice((-1, 0, 0, 1))
        if number // 2 >= len(at):
            size = chance.randrange(len(data))
        path.write_bytes(data[: max(size, 0)])
        judged(found, f"{kind}, cut to {size}", lambda: look(path))
        judged(found, f"{kind}, cut to {size}, no verification", lambda: whatever_is_there(path))
    return found


def whatever_is_there(path: Path) -> str:
    """Read without verification: zeros for what is missing would be wrong."""
    try:
        with open_run(path) as run:
            read = [run.frame_at(i) for i in range(len(run))]
            events = run.events
    except RecordError:
        return "refused"
    same = len(read) == COUNT and len(events) == COUNT // 5 and all(
        np.array_equal(frame.positions, make_frame(i, 24).positions)
        and np.array_equal(frame.edge_tension, make_frame(i, 24).edge_tension)
        for i, frame in enumerate(read)
    )  # fmt: skip
    return GOOD if same else "wrong"


def resumes(folder: Path, trials: int) -> Found:
    """Resumes of damaged runs: they go on from right rows, or not at all, and leave the file alone."""
    found, chance = Found("resumes of damaged runs"), random.Random(16)
    data = killed(folder)
    path = folder / "resumed.h5"

    def trial() -> str:
        before = path.read_bytes()
        try:
            writer = resume_copy(path)
        except DerodError:
            return "refused" if path.read_bytes() == before else "changed, and refused"
        writer.finish(Ending(Outcome.INTERRUPTED, "", 0.0))
        with open_run(path, verify=True) as run:
            count = len(run)
            return (
                GOOD if count == COUNT and all(is_frame(run, i) for i in range(count)) else "wrong"
            )

    for _ in range(trials):
        place, changed = flipped(data, chance)
        path.write_bytes(changed)
        judged(found, f"resume, byte {place}", trial)
    return found
