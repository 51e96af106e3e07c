"""Boxes of parameters, and scenes drawn from them by a seed."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

import derod

STEPS = (0.02, 0.05, 0.1)  # pi D
EDGES = (150, 200, 400)
LANDINGS = (0.12, 0.25, 0.5, 0.75, 0.9)  # of the stop
START = 0.02 * math.pi


class Box(NamedTuple):
    """Ranges that parameters are drawn from."""

    length: tuple[float, float]  # l
    twisting: tuple[float, float]  # k3
    capillary_force: tuple[float, float]  # f_gamma
    wall_softness: tuple[float, float]  # rho
    wall_strength: tuple[float, float]  # v0, by its logarithm


BOXES = {
    "wide": Box((6, 24), (0.5, 1.5), (5, 80), (0.02, 0.3), (1e-5, 5e-2)),
    "hard": Box((6, 9), (0.5, 1.5), (8, 30), (0.02, 0.1), (1e-4, 5e-3)),
    "weak": Box((6, 24), (0.5, 1.5), (4.5, 8), (0.02, 0.3), (1e-5, 5e-2)),
    "heavy": Box((6, 16), (0.5, 1.5), (8, 60), (0.02, 0.3), (1e-4, 5e-2)),
    "steps": Box((6, 16), (0.5, 1.5), (10, 40), (0.05, 0.3), (1e-4, 5e-2)),
    "sections": Box((6, 16), (0.4, 1.5), (8, 40), (0.05, 0.3), (1e-4, 5e-2)),
}
ORDER = (
    "hard",
    "weak",
    "wide",
    "heavy",
    "steps",
    "sections",
)  # new ones last: seeds keep their scenes
WEIGHTS = (0.005, 0.4)  # of f_gamma
HARDER = (1.2, 30)  # K2/K1


def draw(box: str, seed: int, number: int) -> derod.Scene:
    """Return scene ``number`` of a seed: the same whatever else is drawn."""
    rng = np.random.default_rng([seed, number, ORDER.index(box)])
    ranges = BOXES[box]
    length = rng.uniform(*ranges.length)
    rotation = rng.choice([0.0, 2 * math.pi, rng.uniform(0, 4 * math.pi)])
    stop = rng.uniform(0.75, 0.95) * (length - 1)
    step = rng.choice(STEPS) * math.pi
    tables: dict[str, Any] = {
        "rod.length": length,
        "rod.twisting": rng.uniform(*ranges.twisting),
        "drop.capillary_force": rng.uniform(*ranges.capillary_force),
        "drop.wall_softness": rng.uniform(*ranges.wall_softness),
        "drop.wall_strength": math.exp(rng.uniform(*np.log(ranges.wall_strength))),
        "clamps.end_rotation": rotation,
        "mesh.edges": int(rng.choice(EDGES)),
        "push.start": START,
        "push.stop": stop,
        "push.max_step": step,
        "push.at": [share * stop for share in LANDINGS],
    }
    if box in ("heavy", "steps", "sections"):
        tables["push.stop"] = stop = stop * rng.uniform(0.3, 0.9)
        tables["push.at"] = [share * stop for share in LANDINGS]
    if box == "heavy":
        tables["drop.weight"] = tables["drop.capillary_force"] * math.exp(
            rng.uniform(*np.log(WEIGHTS))
        )
    rounded = {
        key: value if isinstance(value, (int, list)) else float(f"{value:.5g}")
        for key, value in tables.items()
    }
    if box == "heavy":
        rounded["push.bend"] = str(rng.choice(["down", "up"]))
    if box == "steps":
        rounded["steps"] = draw_steps(rng, rounded)
    if box == "sections":
        del rounded["clamps.end_rotation"]
        rounded |= draw_section(rng)
    return derod.parse_scene(PLAIN).replace(rounded)


def draw_section(rng: np.random.Generator) -> dict[str, Any]:
    """Return two stiffnesses, directors along a principal axis or not, and now and then a natural shape."""
    start = rng.choice([0.0, 0.5 * math.pi, rng.uniform(0, math.pi)])
    end = start + rng.choice([0.0, 0.0, rng.uniform(-2, 2)])
    hard = math.exp(rng.uniform(*np.log(HARDER)))
    section: dict[str, Any] = {
        "rod.bending": [1.0, float(f"{hard:.5g}")],
        "clamps.directors": [float(start), float(end)],
    }
    if rng.random() < 0.4:
        section["rod.natural_curvature"] = [float(x) for x in rng.uniform(-1, 1, 2).round(3)]
    if rng.random() < 0.3:
        section["rod.natural_twist"] = float(round(rng.uniform(-1, 1), 3))
    return section


def draw_steps(rng: np.random.Generator, tables: dict[str, Any]) -> list[dict[str, Any]]:
    """Return three legs of other controls, each with a landing half way where its beginning is known."""
    values = {
        "end_shortening": tables["push.stop"],
        "end_rotation": tables["clamps.end_rotation"],
        "capillary_force": tables["drop.capillary_force"],
        "wall_strength": tables["drop.wall_strength"],
        "weight": 0.0,
    }
    legs: list[dict[str, Any]] = []
    last = "end_shortening"
    for _ in range(3):
        control = str(rng.choice([name for name in values if name != last]))
        begin = values[control]
        stop = {
            "end_shortening": begin * rng.uniform(0.6, 1.15),
            "end_rotation": begin + rng.uniform(-2, 2) * math.pi,
            "capillary_force": begin * rng.uniform(0.7, 1.5),
            "wall_strength": begin * rng.uniform(0.5, 2),
            "weight": tables["drop.capillary_force"] * rng.uniform(0, 0.2),
        }[control]
        stop = float(f"{stop:.5g}")
        legs.append({"control": control, "stop": stop, "at": [0.5 * (begin + stop)]})
        values[control], last = stop, control
    return legs


PLAIN = """
[rod]
length = 10
bending = 1
twisting = 0.9
[drop]
capillary_force = 20
wall_strength = 2e-4
wall_softness = 0.1
[push]
start = 0.06
stop = 6
"""
