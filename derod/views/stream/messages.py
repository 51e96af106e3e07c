"""What the push tells the process that draws it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from derod.scene import Scene
from derod.views.stream.target import Target


@dataclass(frozen=True, slots=True)
class Begin:
    """The first message: what is pushed and where it shall be shown."""

    target: Target
    scene: Scene
    color: str


@dataclass(frozen=True, slots=True)
class Step:
    """A step of a relaxation that is watched."""

    increment: int
    number: int  # of the steps watched so far
    end_shortening: float
    residual: float
    positions: np.ndarray  # (N+1, 3), D
    drop_center: np.ndarray  # (3,), D
    edge_tension: np.ndarray  # (N,), K0/D^2
    menisci: tuple[float, float]  # s_A, s_B, D
    forces: tuple[float, float]  # f_A, f_B, K0/D^2
    holonomy: float
