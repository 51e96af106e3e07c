"""The figure scripts are not a package: their folder is put on the path, as running them does."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest

VIZ = Path(__file__).resolve().parents[2] / "viz"
sys.path.insert(0, str(VIZ))

POINT = [
    ("end_shortening", "f8"),
    ("end_tension", "f8"),
    ("energy_hat", "f8"),
    ("wetted_length", "f8"),
    ("unstable_modes", "i4"),
]
SPECIAL = [
    ("kind", "S16"),
    ("index", "i8"),
    ("end_shortening", "f8"),
    ("end_tension", "f8"),
    ("energy_hat", "f8"),
    ("partner", "S32"),
]


class Branch:
    """Looks like a branch of ``derod.open_branches``."""

    class parameters:  # noqa: N801
        wall_softness = 0.1

    def __init__(self, name, delta, t, energy, modes, specials=()):
        self.name = name
        self.table = np.zeros(len(delta), POINT)
        self.table["end_shortening"], self.table["end_tension"] = delta, t
        self.table["energy_hat"], self.table["unstable_modes"] = energy, modes
        self.table["wetted_length"] = 2.0
        self.bifurcations = np.array(list(specials), SPECIAL)

    def arc_length(self, i):
        return np.linspace(0, 10, 201)

    def positions(self, i):
        s = self.arc_length(i)
        bump = 0.2 * np.exp(-((s - 5) ** 2))
        return np.stack([0.3 * bump, bump, s - self.table["end_shortening"][i] * s / 10], axis=1)

    def drop_center(self, i):
        return np.array([0, 0, 5 - self.table["end_shortening"][i] / 2])


class File(dict):
    """Looks like ``derod.open_branches(path)``."""

    path = "branches.h5"

    class parameters:  # noqa: N801
        capillary_force = 20.0


@pytest.fixture
def branches():
    delta = np.linspace(0, np.pi, 11)
    file = File()
    file["Ax"] = Branch(
        "Ax", delta, 4 + delta, delta**2, np.where(np.arange(11) < 4, 0, 1),
        [(b"pitchfork", 4, delta[4], 5.0, 1.5, b"3D"), (b"pitchfork", 7, delta[7], 5, 1, b""),
         (b"fold", 9, delta[9], 6.0, 9.0, b"")],
    )  # fmt: skip
    file["3D"] = Branch("3D", delta[4:], 5 + delta[4:], delta[4:], np.zeros(7, int))
    file["3D-L2"] = Branch("3D-L2", delta + 2 * np.pi, 5 + delta, delta, np.zeros(11, int))
    return file


@pytest.fixture
def run():
    """A push without physics, but with a shape that can be drawn."""
    from derod.pushing.frames import Ending, Event, Frame, Outcome
    from derod.pushing.rows import ROW
    from derod.record import MemoryRun
    from tests.synthetic import small_scene

    scene, memory = small_scene(mesh__edges=80), MemoryRun()
    memory.start(scene, 0)
    s = np.linspace(0, 10, 81)
    for i in range(30):
        row = np.zeros((), ROW)
        delta = 0.1 * (i + 1)
        row["increment"], row["end_shortening"], row["end_tension"] = i, delta, 10 + i / 10
        row["energy_bend"], row["energy_twist"], row["energy_wall"] = 2 * delta, 0.3, 0.1
        row["energy_capillary"] = -20 * (1 + 0.9 * delta)
        row["energy_total"] = 2 * delta + 0.4 - 20 * (1 + 0.9 * delta)
        row["energy_hat"] = row["energy_total"] + 20 * (delta + 1)
        row["meniscus_a"], row["meniscus_b"] = 4.5 - delta / 2, 5.5 + delta / 2
        row["wetted_length"] = 1 + delta
        depth = 0.4 * np.exp(-2 * (s - 5) ** 2)
        out = 0.3 * np.sin(3 * s) * depth if i >= 10 else 0 * s
        x = np.stack([out, depth, s * (10 - delta) / 10], axis=1)
        if i == 10:
            memory.event(Event(i, "instability", delta, 1.0, 0.9, "left the plane"))
        tension = np.where(abs(s[1:] - 5) < 1, -5.0, 15.0)
        memory.frame(Frame(row[()], x, s, np.array([0, 0, 5 - delta / 2]), tension))
    memory.finish(Ending(Outcome.COMPLETED, "done", 3.0))
    return memory
