"""A push that can be drawn, as an object and as a file, and a real branch file with the path Ax."""

from __future__ import annotations

import numpy as np
import pytest

from tests.viz.conftest import branches, run

__all__ = ["branches", "run"]


@pytest.fixture
def run_file(run, tmp_path):
    from derod.record import RunWriter

    path = tmp_path / "coil.h5"
    writer = RunWriter(path)
    writer.start(run.scene, 0)
    for i in range(len(run)):
        for event in run.events:
            if event.increment == i:
                writer.event(event)
        writer.frame(run.frame_at(i))
    writer.finish(run.ending)
    return path


@pytest.fixture(scope="session")
def ax_file(tmp_path_factory):
    from derod.branches.files.writing import write_branches
    from derod.branches.half_rod.parameters import Parameters
    from derod.branches.paths.arc import Control
    from derod.branches.paths.catalogue import Catalogue

    made = Catalogue(Parameters(), Control(tolerance=1e-9, largest_step=0.4, turning=0.4))
    made.ax()
    path = tmp_path_factory.mktemp("plots") / "ax.h5"
    write_branches(path, Parameters(), [made.store(made.paths["Ax"])], "")
    return path


@pytest.fixture
def ax(ax_file):
    import derod

    with derod.open_branches(ax_file) as file:
        yield file


@pytest.fixture
def along_ax(ax):
    """A run in memory whose increments are points of Ax, the tension of the third 1 % too large."""
    from derod.pushing.frames import Ending, Frame, Outcome
    from derod.pushing.rows import ROW
    from derod.record import MemoryRun
    from tests.scenes import coil

    branch, memory = ax["Ax"], MemoryRun()
    memory.start(coil(), 0)
    for i in range(4):
        point = branch.table[3 + 3 * i]
        row = np.zeros((), ROW)
        for name in ("end_shortening", "end_tension", "energy_hat", "wetted_length"):
            row[name] = point[name]
        row["end_tension"] *= 1.01 if i == 2 else 1.0
        s = branch.arc_length(3 + 3 * i)
        center = branch.drop_center(3 + 3 * i)
        memory.frame(Frame(row[()], branch.positions(3 + 3 * i), s, center, np.zeros(s.size - 1)))
    memory.finish(Ending(Outcome.COMPLETED, "done", 1.0))
    return memory
