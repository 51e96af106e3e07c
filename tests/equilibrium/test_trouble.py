"""What is not a number is caught at once, with its place; the state handed in is left as it was."""

from __future__ import annotations

import numpy as np
import pytest

from derod.equilibrium.loop import Outcome, relax
from derod.equilibrium.methods import make_relaxer
from derod.equilibrium.system import System
from derod.pushing.guess import bent_guess
from tests.scenes import coil


@pytest.mark.parametrize("method", ["implicit", "elliptic", "fire"])
def test_a_poisoned_node_is_named(method: str) -> None:
    system = System(coil(edges=40))
    start = bent_guess(system, system.physics, 0.1)
    start.q[17, 1] = np.nan
    solution = relax(make_relaxer(method), system, start)
    assert solution.outcome is Outcome.DIVERGED
    assert "node 17" in solution.message
    assert solution.iterations == 0


def test_a_node_outside_the_wall_is_refused() -> None:
    system = System(coil(edges=40))
    start = bent_guess(system, system.physics, 0.1)
    start.q[20, 1] += 2.0
    solution = relax(make_relaxer("implicit"), system, start)
    assert solution.outcome is Outcome.DIVERGED
    assert "outside the wall" in solution.message
