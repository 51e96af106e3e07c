"""A coil in space with its end turned, and one that is unstable in its plane."""

from __future__ import annotations

import pytest

import derod
from derod.record import BaseRun
from tests.scenes import coil


@pytest.fixture(scope="package")
def run() -> BaseRun:
    """Twisted, in space, to 0.5 pi."""
    return derod.push(coil(edges=120, rotation=1.5, stop='"0.5 pi"', at='["0.3 pi"]'))


@pytest.fixture(scope="package")
def planar() -> BaseRun:
    """Without noise: unstable from 0.243 pi on."""
    return derod.push(coil(edges=60, noise=0.0, stop='"0.4 pi"', at='["0.2 pi"]'))
