"""Scenes that many tests use, made from one text."""

from __future__ import annotations

import derod
from derod.scene import Scene

COIL = """
[rod]
length = 10
bending = 1
twisting = 0.9
[drop]
capillary_force = 20
wall_strength = {wall}
wall_softness = 0.1
[clamps]
end_rotation = {rotation}
[push]
start = "0.001 pi"
stop = {stop}
at = {at}
max_step = "0.02 pi"
[mesh]
edges = {edges}
[noise]
seed = 1
amplitude = {noise}
[model]
dimension = {dimension}
"""


def coil(
    edges: int = 60,
    stop: str = '"0.3 pi"',
    at: str = "[]",
    wall: float = 2e-4,
    rotation: float = 0.0,
    noise: float = 1e-3,
    dimension: int = 3,
) -> Scene:
    """The paper's rod on a coarse mesh."""
    return derod.parse_scene(
        COIL.format(
            edges=edges,
            stop=stop,
            at=at,
            wall=wall,
            rotation=rotation,
            noise=noise,
            dimension=dimension,
        )
    )
