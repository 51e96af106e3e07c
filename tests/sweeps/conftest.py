"""Plans and folders for sweeps under test."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from derod.sweeps.plan import Plan, make_plan
from tests.scenes import coil

Make = Callable[..., Plan]


@pytest.fixture
def plan() -> Make:
    """A plan of ``count`` capillary forces; a real push of it takes some 20 ms."""

    def make(count: int = 8, **options: Any) -> Plan:
        scene = coil(edges=40, stop='"0.1 pi"', at='["0.05 pi"]')
        forces = {"from": 15.0, "to": 30.0, "count": count}
        return make_plan(scene, {"drop.capillary_force": forces}, **options)

    return make


@pytest.fixture
def log(tmp_path: Path) -> str:
    """A folder where points note that they were begun."""
    folder = tmp_path / "begun"
    folder.mkdir()
    return str(folder)
