"""The clamped-clamped elastica without a drop, against elliptic integrals."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import brentq
from scipy.special import ellipe, ellipk

import derod
from derod.equilibrium.loop import relax
from derod.equilibrium.measured import measure
from derod.equilibrium.methods import make_relaxer
from derod.equilibrium.system import System
from derod.pushing.controls import CONTROLS
from derod.pushing.guess import bent_guess

SCENE = """
[rod]
length = 1
bending = {bending}
twisting = 0.9
[push]
start = 0.2
stop = 0.3
[mesh]
edges = {edges}
[model]
dimension = {dimension}
drop = false
"""


def closed_form(shortening: float) -> tuple[float, float]:
    """Load P L^2/K = 16 K(m)^2 and mid-height over L at the end shortening (over L)."""
    m = brentq(lambda m: 2 * (1 - ellipe(m) / ellipk(m)) - shortening, 1e-9, 0.9)
    return 16 * ellipk(m) ** 2, np.sqrt(m) / ellipk(m)


def relaxed(
    edges: int, shortening: float, dimension: int = 2, bending: float = 1.0
) -> tuple[float, float]:
    """Load and mid-height of the discrete rod."""
    scene = derod.parse_scene(SCENE.format(edges=edges, dimension=dimension, bending=bending))
    system = System(scene)
    solution = relax(
        make_relaxer("implicit"), system, bent_guess(system, system.physics, shortening)
    )
    assert solution.converged, solution.message
    assert measure(system, solution.state, CONTROLS["end_shortening"]).unstable_modes == 0
    system.gradient(solution.state)
    return -system.end_tension(solution.state), abs(solution.state.positions[:, 1]).max()


def test_closed_form_itself() -> None:
    load, height = closed_form(0.2)
    assert load == pytest.approx(43.92916, abs=5e-6)
    assert height == pytest.approx(0.2663186, abs=5e-8)


@pytest.mark.parametrize("dimension", [2, 3])
def test_error_and_rate(dimension: int) -> None:
    exact = np.array(closed_form(0.2))
    coarse = np.abs(np.array(relaxed(50, 0.2, dimension)) / exact - 1)
    fine = np.abs(np.array(relaxed(100, 0.2, dimension)) / exact - 1)
    assert (fine < 1e-5).all()
    assert (np.log2(coarse / fine) > 3.5).all()


def test_euler_load_and_its_rate() -> None:
    """A barely bent rod carries 4 pi^2 K/L^2 (1 + shortening/4 + ...)."""
    shortening = 1e-4
    exact = closed_form(shortening)[0]
    assert exact == pytest.approx(4 * np.pi**2, rel=1e-4)
    coarse = abs(relaxed(40, shortening)[0] / exact - 1)
    fine = abs(relaxed(80, shortening)[0] / exact - 1)
    assert fine < 1e-5
    assert np.log2(coarse / fine) > 3.5
