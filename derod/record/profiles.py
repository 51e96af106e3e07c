"""What the rod can be coloured by, at its nodes, and the colours: safe for colour-blind eyes."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from derod.record.geometry import tangents_with_clamps, unit
from derod.scene import Scene

VIRIDIS = [
    (96, 92, 172), (66, 110, 168), (43, 116, 142), (34, 141, 141), (33, 166, 133),
    (64, 189, 114), (119, 209, 83), (186, 222, 40), (253, 231, 37),
]  # fmt: skip
PLASMA = [
    (65, 4, 157), (108, 0, 168), (149, 17, 161), (182, 48, 139), (209, 78, 114),
    (231, 110, 91), (247, 144, 68), (254, 184, 44), (247, 228, 37),
]  # fmt: skip
BLUE_RED = [
    (27, 90, 156), (62, 140, 191), (138, 192, 219), (207, 228, 239), (247, 246, 246),
    (253, 217, 196), (241, 158, 125), (208, 85, 72), (162, 19, 40),
]  # fmt: skip


FORCE_WITHOUT_DROP = 50.0  # K0/D^2, the scale of tensions where no drop gives one


class Coloring(NamedTuple):
    """How a field is shown: values from ``low`` to ``high`` over the colours, evenly."""

    low: float
    high: float
    colors: list[tuple[int, int, int]]
    meaning: str


def coloring(name: str, scene: Scene) -> Coloring:
    """The fixed scale of a field: the same colour is the same value in every frame."""
    f_gamma = FORCE_WITHOUT_DROP if scene.drop is None else scene.drop.capillary_force
    turn = 2 * np.pi / scene.rod.length
    if name == "curvature":
        return Coloring(0.0, 6.0, VIRIDIS, "curvature, 0 to 6 /D")
    if name == "tension":
        return Coloring(-f_gamma, f_gamma, BLUE_RED, f"tension, -{f_gamma:g} to {f_gamma:g} K0/D^2")
    if name == "wall":
        return Coloring(0.0, 2 * f_gamma, PLASMA, f"wall's push, 0 to {2 * f_gamma:g} K0/D^3")
    if name == "twist":
        return Coloring(
            -turn, turn, BLUE_RED, f"twist u3, -{turn:.3g} to {turn:.3g} rad/D, uniform"
        )
    raise ValueError(f"no field {name!r} to colour by; allowed: {', '.join(FIELDS)}")


FIELDS = ("curvature", "tension", "wall", "twist")


def paint(values: np.ndarray, scale: Coloring) -> np.ndarray:
    """Colours (..., 3) uint8 of ``values`` (...), clipped to the scale."""
    place = np.clip((values - scale.low) / (scale.high - scale.low), 0.0, 1.0)
    stops = np.linspace(0.0, 1.0, len(scale.colors))
    table = np.asarray(scale.colors, dtype=float)
    channels = [np.interp(place, stops, table[:, k]) for k in range(3)]
    return np.stack(channels, axis=-1).round().astype(np.uint8)


def curvature(positions: np.ndarray, arc_length: np.ndarray) -> np.ndarray:
    """Turning angle over dual length at the nodes, (..., N+1), 1/D; half cells at the clamps."""
    tangents = tangents_with_clamps(positions)
    a, b = tangents[..., :-1, :], tangents[..., 1:, :]
    sine = np.linalg.norm(np.cross(a, b), axis=-1)
    angle = np.arctan2(sine, np.einsum("...i,...i->...", a, b))
    lengths = np.diff(arc_length, axis=-1)
    ends = np.zeros((*lengths.shape[:-1], 1))
    around = np.concatenate([ends, lengths, ends], axis=-1)
    return np.asarray(angle / (0.5 * (around[..., 1:] + around[..., :-1])))


def curvature_vector(positions: np.ndarray, arc_length: np.ndarray) -> np.ndarray:
    """The curvature binormal kappa b at the nodes, (..., N+1, 3), 1/D; its length is ``curvature``."""
    tangents = tangents_with_clamps(positions)
    across = np.cross(tangents[..., :-1, :], tangents[..., 1:, :])
    return np.asarray(unit(across) * curvature(positions, arc_length)[..., None])


def node_tension(edge_tension: np.ndarray) -> np.ndarray:
    """Mean tension of the edges that meet at the nodes, (..., N+1), K0/D^2."""
    t = np.asarray(edge_tension)
    around = np.concatenate([t[..., :1], t, t[..., -1:]], axis=-1)
    return np.asarray(0.5 * (around[..., 1:] + around[..., :-1]))


def wetted(arc_length: np.ndarray, meniscus_a: np.ndarray, meniscus_b: np.ndarray) -> np.ndarray:
    """Which nodes lie in the drop, (..., N+1); the menisci are nodes and count."""
    slack = 1e-9
    low, high = np.asarray(meniscus_a) - slack, np.asarray(meniscus_b) + slack
    return np.asarray((arc_length >= low[..., None]) & (arc_length <= high[..., None]))


def wall_push(positions: np.ndarray, drop_center: np.ndarray, scene: Scene) -> np.ndarray:
    """The wall's push toward the drop's centre as if wetted, dv/dr (..., N+1), K0/D^3.

    v = v0 / (1 + rho - 2 r). Nodes beyond the wall, which no equilibrium has, give nothing.
    """
    if scene.drop is None:
        return np.zeros(positions.shape[:-1])
    r = np.linalg.norm(positions - drop_center[..., None, :], axis=-1)
    gap = 1 + scene.drop.wall_softness - 2 * r
    return np.where(gap > 0, 2 * scene.drop.wall_strength / np.maximum(gap, 1e-9) ** 2, 0.0)
