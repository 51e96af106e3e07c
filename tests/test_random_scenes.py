"""Scenes of fixed seeds, drawn at random: every law holds, and the step does not decide where they end.

The quick suite pushes ten; the validation suite sixty. ``runs/random_scenes.py`` pushes any number.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest

import derod
from derod.equilibrium.loop import Report
from derod.equilibrium.system import System
from derod.pushing.guess import bent_guess
from tests.scenes import coil

sys.path.insert(0, str(Path(__file__).parents[1] / "runs"))

from drawn.boxes import BOXES, draw
from drawn.descents import Descents
from drawn.laws import audit, disagreements, side_was_open

QUICK = [("wide", 0), ("wide", 1), ("wide", 2), ("wide", 3), ("hard", 0), ("hard", 1), ("hard", 2),
         ("weak", 0), ("weak", 1), ("weak", 2)]  # fmt: skip
SLOW = [(box, number) for box in BOXES for number in range(10, 30)]
SEED = 7


def check(box: str, number: int) -> None:
    scene = draw(box, SEED, number)
    run = derod.push(scene)
    finer = derod.push(scene.replace({"push.max_step": scene.push.max_step / 4}))
    for one in (run, finer):
        assert one.ending is not None and one.ending.outcome == "completed", one.ending
        assert audit(one) == []
    if not side_was_open(run):
        assert disagreements(run, finer) == []


@pytest.mark.parametrize(("box", "number"), QUICK)
def test_a_few(box: str, number: int) -> None:
    check(box, number)


@pytest.mark.validation
@pytest.mark.parametrize(("box", "number"), SLOW)
def test_many(box: str, number: int) -> None:
    check(box, number)


def test_a_scene_does_not_depend_on_what_else_is_drawn() -> None:
    assert draw("wide", 3, 5) == draw("wide", 3, 5)
    assert draw("wide", 3, 5) != draw("wide", 3, 6)
    assert draw("hard", 3, 5) != draw("wide", 3, 5)


class Altered:
    """A run whose table was tampered with."""

    def __init__(self, run, **columns: object) -> None:
        self.run = run
        self.table = run.table.copy()
        for name, change in columns.items():
            self.table[name] = change(self.table[name])

    def __getattr__(self, name: str) -> object:
        return getattr(self.run, name)

    def __len__(self) -> int:
        return len(self.table)


def lifted(column: np.ndarray) -> np.ndarray:
    """All rows from the middle on are 0.05 higher."""
    out = column.copy()
    out[len(out) // 2 :] += 0.05
    return out


def test_the_laws_see_what_is_wrong() -> None:
    """Each law fails on a table that breaks it."""
    run = derod.push(coil(stop='"0.2 pi"'))
    assert audit(run) == []
    hidden = {
        "energy_total": lifted,
        "energy_hat": lifted,
        "energy_bend": lifted,
    }
    assert any("gains" in fault for fault in audit(Altered(run, **hidden)))
    sunk = {name: lambda c: c - 10 * (lifted(c) - c) for name in hidden}
    assert any("silently" in fault for fault in audit(Altered(run, **sunk)))
    assert any("add up" in f for f in audit(Altered(run, energy_wall=lambda c: c + 1e-6)))
    assert any("jumps" in f for f in audit(Altered(run, holonomy=lambda c: 100 * lifted(c))))
    assert any("unstable" in f for f in audit(Altered(run, unstable_modes=lambda c: c + 1)))
    assert any("converged" in f for f in audit(Altered(run, converged=lambda c: c & False)))
    assert any("work_defect" in f for f in audit(Altered(run, work_defect=lambda c: c + 0.5)))


def test_descents_are_watched() -> None:
    """The watcher counts the steps of a kick's descent, and an uphill one if there is one."""
    watch = Descents()
    derod.push(coil(stop='"0.27 pi"'), None, [watch])
    assert watch.steps > 5 and watch.uphill == 0
    system = System(coil())
    watch.start(coil(), 0)
    state = bent_guess(system, system.physics, 0.1)
    report = Report(1, 1.0, 1.0, True, True, descending=True)
    watch.relaxation(0, 0, state, report)
    state.b[:2] += (0.1, -0.1)  # less wetted, for more energy
    watch.relaxation(0, 1, state, report)
    assert watch.uphill == 1
