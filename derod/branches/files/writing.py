"""A branch file under way: every branch is in the file as soon as it is done."""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Self

import h5py
import numpy as np

from derod.branches.files import checking
from derod.branches.files.layout import BIFURCATION, FORMAT, POINT
from derod.branches.half_rod.observables import SCALED
from derod.branches.half_rod.parameters import Parameters
from derod.branches.paths.branch import Branch
from derod.errors import RecordError
from derod.files import checks, lock, outputs


@dataclass(frozen=True, slots=True)
class Settings:
    """What was asked for, kept so that a computation that was stopped can go on."""

    paths: tuple[str, ...] | None = None
    tolerance: float = 1e-10
    max_step: float = 0.22
    accuracy: float = 1e-8
    count_modes: bool = True

    def dump(self) -> str:
        """As text."""
        return json.dumps(asdict(self))

    @classmethod
    def load(cls, text: str, path: str) -> Self:
        """From the text of ``dump``; raises RecordError."""
        try:
            values = json.loads(text)
            paths = values.pop("paths")
            if paths is not None:
                paths = tuple(str(name) for name in paths)
            return cls(paths=paths, **values)
        except (AttributeError, KeyError, TypeError, ValueError) as error:
            raise RecordError(
                f"{path}: cannot be resumed: it does not say what was asked for"
            ) from error


class BranchWriter:
    """Writes branches to ``path``, one after another, each in one step; a context.

    A file that exists stays until the first branch is there to replace it, and is locked all the
    while; where there is none the name is reserved. With ``resume`` the branches that are there
    stay. Raises RecordError, InUseError.
    """

    def __init__(
        self,
        path: str | Path,
        parameters: Parameters,
        scene_text: str,
        settings: Settings,
        *,
        overwrite: bool = False,
        resume: bool = False,
        reserve: bool = True,
    ) -> None:
        self.path = str(path)
        self.target = outputs.check_output(path, force=overwrite or resume, make_folders=False)
        self._parameters, self._scene_text, self._settings = parameters, scene_text, settings
        self._held: lock.Lock | None = None
        self._begun = resume
        outputs.sweep(self.target)
        if self.target.exists():
            self._held = lock.Lock.take(str(self.target))
        elif reserve:  # the name is taken, and says that nothing is finished
            self._change(lambda file: None)

    def put(self, *branches: Branch, complete: bool = False) -> None:
        """Write branches, in one step; with ``complete`` the file says that there are no more to come."""

        def change(file: h5py.File) -> None:
            for branch in branches:
                write_branch(file["branches"].create_group(branch.name), branch)
            file.attrs["complete"] = np.int8(complete)

        self._change(change)

    def _change(self, change: Callable[[h5py.File], None]) -> None:
        """Make the file anew with one thing changed, and let it take the old one's place."""
        passing = outputs.passing_name(self.target)
        held = None
        try:
            passing.unlink(missing_ok=True)
            held = lock.Lock.make(str(passing))
            if self._begun:
                shutil.copyfile(self.target, passing)
            mode = "r+" if self._begun else "w"
            with h5py.File(passing, mode, libver=("v110", "v110"), locking=False) as file:
                if not self._begun:
                    self._write_head(file)
                change(file)
                attributes = checks.attributes(file)
                check = checking.head_check(attributes, list(file["branches"]))
                file.attrs["check"] = np.uint64(check)
            outputs.publish(passing, self.target, self._held)
        except BaseException as error:
            if held is not None:
                held.release()
            passing.unlink(missing_ok=True)
            if isinstance(error, OSError | RuntimeError):
                reason = outputs.words(error)
                raise RecordError(f"{self.path}: cannot be written: {reason}") from error
            raise
        if self._held is not None:
            self._held.release()
        self._held, self._begun = held, True

    def _write_head(self, file: h5py.File) -> None:
        file.attrs["format"] = FORMAT
        file.attrs["units"] = "lengths D, forces K0/D^2, energies K0/D, angles radians"
        file.attrs["scene"] = self._scene_text
        file.attrs["settings"] = self._settings.dump()
        file.attrs["complete"] = np.int8(0)
        for name, value in asdict(self._parameters).items():
            file.attrs[name] = value
        file.create_group("branches", track_order=True)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        if self._held is not None:
            self._held.release()


def write_branches(
    path: str | Path,
    parameters: Parameters,
    branches: list[Branch],
    scene_text: str = "",
    *,
    overwrite: bool = True,
) -> None:
    """Write branches to a file, complete or not at all. Raises RecordError, OSError."""
    settings = Settings()
    with BranchWriter(
        path, parameters, scene_text, settings, overwrite=overwrite, reserve=False
    ) as writer:
        writer.put(*branches, complete=True)


def write_branch(group: h5py.Group, branch: Branch) -> None:
    """Write one branch into its group."""
    table = np.zeros(len(branch.points), POINT)
    for row, point in zip(table, branch.points, strict=True):
        for name, value in point.values.items():
            row[name] = value
        for name in SCALED:
            row[name] *= point.state.parameters.bending
        row["error"] = point.error
        row["unstable_modes"] = point.unstable_modes
        row["elements"] = point.state.eta.size
        row["inner"] = point.state.inner
        row["scalars"] = point.state.scalars[:6]  # the weight is an attribute of the file
    bifurcations = np.zeros(len(branch.bifurcations), BIFURCATION)
    for row, special in zip(bifurcations, branch.bifurcations, strict=True):
        at = table[special.index]
        row["kind"], row["index"], row["partner"] = special.kind, special.index, special.partner
        for name in ("end_shortening", "end_tension", "energy_hat"):
            row[name] = at[name]
        row["test_function"] = special.function
    group.attrs["begins"] = branch.begins
    group.attrs["ends"] = branch.ends
    group.attrs["remarks"] = "\n".join(branch.remarks)
    group.attrs["mirror"] = branch.even.name
    group["table"] = table
    group["bifurcations"] = bifurcations
    group["nodes"] = np.concatenate([p.state.nodes for p in branch.points])
    group["eta"] = np.concatenate([p.state.eta for p in branch.points])
    group.attrs["check"] = np.uint64(checking.group_check(branch.name, group))
