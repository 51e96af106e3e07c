"""Hostile HDF5 files: one line, bounded time and memory, and nothing outside the file is read."""

from __future__ import annotations

import os
import random
import resource
from collections.abc import Callable
from pathlib import Path

import h5py
import numpy as np

from derod.errors import DerodError
from derod.record import layout, open_run
from tests.validation.faults.corruptions import COUNT, finished, judged
from tests.validation.faults.trial import Found

MOST_MEMORY = 200e6  # bytes more than before
SECRET = 12345.678
Change = Callable[[h5py.File, Path], None]
ARRAY = f"{layout.POSITION}/value"
PARTS = (
    layout.COMMITTED, layout.COMMITTED_CHECK, layout.ENDING, layout.EVENTS, layout.SCENE, ARRAY,
    f"{layout.TABLE}/value", f"{layout.POSITION}/step", "parameters",
)  # fmt: skip


def without(file: h5py.File, name: str) -> tuple[tuple[int, ...], np.dtype]:
    """Take a dataset away; return what it was like."""
    shape, dtype = getattr(file[name], "shape", ()), getattr(file[name], "dtype", np.dtype("i8"))
    del file[name]
    return shape, dtype


def external_link(name: str) -> Change:
    """A part that lies in another file."""

    def change(file: h5py.File, secret: Path) -> None:
        del file[name]
        file[name] = h5py.ExternalLink(str(secret), name if name in file else "/x")

    return change


def soft_link(name: str) -> Change:
    """A part that leads to itself."""

    def change(file: h5py.File, secret: Path) -> None:
        del file[name]
        file[name] = h5py.SoftLink(f"/{name}")

    return change


def virtual(name: str) -> Change:
    """A part mapped onto another file."""

    def change(file: h5py.File, secret: Path) -> None:
        shape, dtype = without(file, name)
        mapped = h5py.VirtualLayout(shape, dtype)
        mapped[...] = h5py.VirtualSource(str(secret), "/x", shape=shape)
        file.create_virtual_dataset(name, mapped)

    return change


def external_storage(name: str) -> Change:
    """A part whose values lie in another file."""

    def change(file: h5py.File, secret: Path) -> None:
        shape, dtype = without(file, name)
        size = int(np.prod(shape or (1,))) * dtype.itemsize
        file.create_dataset(name, shape, dtype, external=[(str(secret), 0, max(size, 1))])

    return change


def bomb(name: str) -> Change:
    """A part of a gigabyte and more, packed into nothing."""

    def change(file: h5py.File, secret: Path) -> None:
        _, dtype = without(file, name)
        file.create_dataset(
            name, (COUNT, 4_000_000, 3)[: 3 if name == ARRAY else 2], dtype, compression="gzip",
            chunks=(1, 1_000_000, 3)[: 3 if name == ARRAY else 2],
        )  # fmt: skip

    return change


def endless(name: str) -> Change:
    """A part that says it has 2^60 rows."""

    def change(file: h5py.File, secret: Path) -> None:
        shape, dtype = without(file, name)
        file.create_dataset(name, (2**50, *shape[1:]), dtype, chunks=(1, *shape[1:]))
        if layout.COMMITTED in file:
            file[layout.COMMITTED][...] = (2**50, 0)

    return change


def other_type(name: str) -> Change:
    """A part of objects, references or texts without end."""

    def change(file: h5py.File, secret: Path) -> None:
        shape, _ = without(file, name)
        kinds = (
            h5py.ref_dtype,
            h5py.string_dtype(),
            h5py.vlen_dtype("f8"),
            h5py.opaque_dtype("V9"),
        )
        kind = kinds[len(name) % len(kinds)]
        file.create_dataset(name, shape, kind if kind is not None else "f4")

    return change


def other_shape(name: str) -> Change:
    """A part of another shape."""

    def change(file: h5py.File, secret: Path) -> None:
        _, dtype = without(file, name)
        file.create_dataset(name, (3, 2, 7, 1), dtype)

    return change


def missing(name: str) -> Change:
    """No such part."""

    def change(file: h5py.File, secret: Path) -> None:
        del file[name]

    return change


def group(name: str) -> Change:
    """A group, or a dataset, where the other should be."""

    def change(file: h5py.File, secret: Path) -> None:
        was = isinstance(file[name], h5py.Group)
        del file[name]
        if was:
            file[name] = 1
        else:
            file.create_group(name)

    return change


KINDS = (external_link, soft_link, virtual, external_storage, bomb, endless, other_type, other_shape,
         missing, group)  # fmt: skip


def hostile_files(folder: Path, trials: int) -> Found:
    """Every part of a run file in every way that is not ours; secrets are a file and a pipe."""
    found = Found("hostile HDF5 files")
    data = finished(folder)
    secret, pipe = folder / "secret.h5", folder / "pipe"
    with h5py.File(secret, "w") as file:
        file["x"] = np.full((COUNT, 25, 3), SECRET)
    os.mkfifo(pipe)  # nobody writes into it: whoever opens it waits
    made = [(kind, name) for kind in KINDS for name in PARTS]
    random.Random(5).shuffle(made)
    path = folder / "hostile.h5"
    for number in range(trials):
        kind, name = made[number % len(made)]
        path.write_bytes(data)
        try:
            with h5py.File(path, "r+", libver=("v110", "latest")) as file:
                kind(name)(file, pipe if number % 2 else secret)
        except (ValueError, TypeError, OSError, KeyError, RuntimeError):
            path.write_bytes(data[: number * 100])  # h5py will not make it: something else
        judged(found, f"{kind.__name__} of {name}", lambda: bounded(path, found))
    return found


def bounded(path: Path, found: Found) -> str:
    """Read all of a file, or have it refused, in bounded memory."""
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    try:
        with open_run(path, verify=True) as run:
            values = [run.positions(i) for i in range(len(run))]
            _ = run.table, run.events, run.scene, run.versions, run.extrapolated
        outcome = "wrong" if any((value == SECRET).any() for value in values) else "read as written"
    except DerodError as error:
        outcome = "refused" if str(error).isprintable() else "refused in more than a line"
    after = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    if (after - before) * 1024 > MOST_MEMORY:
        found.fail(f"took {(after - before) / 1024:.0f} MB")
    return outcome


def noise(folder: Path, trials: int) -> Found:
    """What is no HDF5 file, or begins as one: noise, texts, formats of others, other HDF5 files."""
    found, chance = Found("files of other kinds"), random.Random(6)
    path = folder / "noise.h5"
    begins = (
        b"",
        b"\x89HDF\r\n\x1a\n",
        b"\x89HDF\r\n\x1a\n\x03\x08\x08\x05",
        b"PK\x03\x04",
        b"[rod]\n",
    )
    for number in range(trials):
        if number % 10 == 9:
            path.unlink(missing_ok=True)
            with h5py.File(path, "w", libver=chance.choice(("earliest", "latest"))) as file:
                file["x"] = chance.random()
                file.attrs["derod_format"] = chance.choice((1, 2, 99, "x", 1.5))
        else:
            path.write_bytes(chance.choice(begins) + chance.randbytes(chance.randrange(4000)))
        judged(found, f"noise {number}", lambda: bounded(path, found))
    return found
