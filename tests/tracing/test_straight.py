"""The straight rod buckles where closed forms say."""

from __future__ import annotations

import math

import pytest

import derod
from derod.equilibrium.system import System
from derod.tracing.straight import bucklings
from tests.scenes import coil

DRY = """
[rod]
length = {length}
bending = {bending}
twisting = 0.9
[push]
start = 0.01
stop = 0.1
[mesh]
edges = {edges}
[model]
dimension = {dimension}
drop = false
"""


def dry(edges: int, dimension: int, length: float = 3.0, bending: float = 1.0) -> System:
    text = DRY.format(length=length, bending=bending, edges=edges, dimension=dimension)
    return System(derod.parse_scene(text))


@pytest.mark.parametrize("dimension", [2, 3])
def test_a_clamped_rod_buckles_at_the_loads_of_euler(dimension: int) -> None:
    """4 pi^2 / l^2 and (2 x)^2 / l^2 with tan x = x, x = 4.4934; each mode in every direction across."""
    found = bucklings(dry(60, dimension), 3)
    wanted = [(2 * math.pi) ** 2, (2 * 4.493409457909064) ** 2, (4 * math.pi) ** 2]
    for one, load in zip(found, wanted, strict=True):
        assert one.tension * 9.0 == pytest.approx(-load, rel=1e-4)
        assert one.change == dimension - 1


def test_the_buckling_load_is_of_fourth_order() -> None:
    load = (2 * math.pi / 3.0) ** 2
    off = [abs(bucklings(dry(edges, 2), 1)[0].tension + load) for edges in (20, 40)]
    assert off[0] / off[1] > 2**3.5


def test_the_rod_in_its_drop_buckles_under_a_pull() -> None:
    """The paper's rod, v0 = 2e-4; modes leave in the y-z plane."""
    found = bucklings(System(coil(edges=200)), 1)[0]
    assert found.tension == pytest.approx(
        3.7248, abs=5e-4
    )  # DESIGN: t = 3.73, 3.7248 at small amplitude
    assert abs(found.mode.rows[:, 0]).max() == 0.0
