"""The way of a push: its legs, each with a control, a goal and landings."""

from __future__ import annotations

import math
from dataclasses import dataclass

from derod.scene.controls import held_value
from derod.scene.tables import Scene

SHORTENING, TENSION = "end_shortening", "end_tension"


@dataclass(frozen=True, slots=True)
class Leg:
    """One stretch of a push, from where the one before ended."""

    control: str
    stop: float
    at: tuple[float, ...]
    max_step: float
    locate: bool
    """Whether events are looked for between increments."""
    slides: bool
    """Whether the end clamp slides under a dead load meanwhile."""
    key: str
    """In the file, for messages."""


def legs(scene: Scene) -> tuple[Leg, ...]:
    """The legs of ``push.stop``, then those of ``[[steps]]``; on every one of them it may land."""
    push = scene.push
    slides = scene.clamps.end_tension is not None or push.control == TENSION

    def locates(control: str) -> bool:
        return control != SHORTENING if push.locate is None else push.locate

    made = []
    for i, stop in enumerate(push.stop):
        key = f"push.stop[{i}]" if len(push.stop) > 1 else "push.stop"
        made.append(
            Leg(push.control, stop, push.at, push.max_step, locates(push.control), slides, key)
        )
    for n, step in enumerate(scene.steps):
        slides = step.control != SHORTENING and (slides or step.control == TENSION)
        for i, stop in enumerate(step.stop):
            key = f"steps[{n}].stop" + (f"[{i}]" if len(step.stop) > 1 else "")
            made.append(
                Leg(step.control, stop, step.at, step.max_step, locates(step.control), slides, key)
            )
    return tuple(made)


def named_controls(scene: Scene) -> list[tuple[str, str]]:
    """The keys that name a control, and what they name."""
    steps = [(f"steps[{n}].control", step.control) for n, step in enumerate(scene.steps)]
    return [("push.control", scene.push.control), *steps]


def slides_at_start(scene: Scene) -> bool:
    """Whether the first state's end slides under a dead load."""
    return scene.clamps.end_tension is not None or scene.push.control == TENSION


def start_value(scene: Scene, control: str) -> float | None:
    """A control's value in the first state, None where nothing tells: then it is what comes out."""
    if control == scene.push.control:
        return scene.push.start
    if control == SHORTENING and slides_at_start(scene):
        return None
    return held_value(scene, control)


def ways(scene: Scene) -> list[tuple[float, float]]:
    """From where to where each leg goes; from nan where a control was free before."""
    values: dict[str, float] = {scene.push.control: scene.push.start}
    slides = slides_at_start(scene)
    out = []
    for leg in legs(scene):
        if leg.slides != slides:  # the end is released, or clamped where it happens to be
            values.pop(TENSION if leg.slides else SHORTENING, None)
            slides = leg.slides
        held = held_value(scene, leg.control)
        begin = values.get(leg.control, math.nan if held is None else held)
        if leg.slides:
            values.pop(SHORTENING, None)
        out.append((begin, leg.stop))
        values[leg.control] = leg.stop
    return out
