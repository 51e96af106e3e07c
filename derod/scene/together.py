"""What the keys of a scene may hold together with each other."""

from __future__ import annotations

import math
from itertools import pairwise

from derod.errors import SceneError
from derod.scene.controls import HELD
from derod.scene.directors import check_directors
from derod.scene.failing import fail
from derod.scene.plan import LEAST_STEP
from derod.scene.program import SHORTENING, legs, named_controls, slides_at_start, ways
from derod.scene.quantities import write_quantity
from derod.scene.rules import KEYS
from derod.scene.tables import Scene

CLAMP_CLEARANCE = 0.9


def largest_end_shortening(length: float) -> float:
    """Above this no push of a rod of this ``length`` can go, in D.

    The clamps stand l - delta apart, and so do the menisci once the outer rod has run out. Menisci
    sit on the sphere, near opposite ends of a diameter: the rod runs out close to delta = l - 1
    (9.01 for l = 10, where they have come a little closer). The bound leaves room for that, so that
    it is the run that finds its own end.
    """
    return length - CLAMP_CLEARANCE


def check_together(scene: Scene) -> None:
    """Check what one key alone cannot tell; raises SceneError."""
    _check_length(scene)
    _check_controls(scene)
    _check_legs(scene)
    _check_landings(scene)
    check_directors(scene)
    if scene.model.dimension == 2 and scene.clamps.end_rotation != 0.0:
        fail(
            scene,
            "clamps.end_rotation",
            scene.clamps.end_rotation,
            "turns the rod out of its plane",
            "0 with model.dimension = 2",
        )


def _check_length(scene: Scene) -> None:
    """A rod in a drop must be longer than the drop is wide."""
    length = scene.rod.length
    if scene.drop is not None and length <= 1.0:
        fail(scene, "rod.length", length, "is out of range", KEYS["rod"]["length"].allowed)


def _reach(scene: Scene) -> tuple[float, str]:
    """What no end-shortening may reach (D), and why."""
    length = scene.rod.length
    if scene.drop is None:
        return length, f"below {length:g}, where the clamps meet"
    limit = largest_end_shortening(length)
    return limit, (
        f"below {limit:g}: with a rod of length {length:g} the clamps would stand "
        f"closer than the menisci (the rod runs out near {length - 1.0:g})"
    )


def _check_controls(scene: Scene) -> None:
    """What pushes must be there, and what does not push must be held."""
    clamps, push = scene.clamps, scene.push
    for key, control in named_controls(scene):
        needs = HELD[control].needs
        if needs == "drop" and scene.drop is None:
            fail(scene, key, control, "needs a drop", "another control, or model.drop = true")
        if needs == "space" and scene.model.dimension == 2:
            fail(scene, key, control, "turns the rod out of its plane", "model.dimension = 3")
    slides = slides_at_start(scene)
    if slides and clamps.end_shortening is not None:
        fail(
            scene,
            "clamps.end_shortening",
            clamps.end_shortening,
            "is held although the end slides under a dead load",
            "no end-shortening with an end tension",
        )
    if push.control == SHORTENING and clamps.end_tension is not None:
        fail(
            scene,
            "clamps.end_tension",
            clamps.end_tension,
            "lets the end slide that the push moves",
            "another push.control, or no end tension",
        )
    if push.control != SHORTENING and not slides and clamps.end_shortening is None:
        raise SceneError(
            f"is missing: nothing holds the end while the {HELD[push.control].words} pushes",
            file=scene.path,
            key="clamps.end_shortening",
            allowed=f"{HELD[SHORTENING].allowed}, or clamps.end_tension",
        )
    if scene.relax.method != "implicit" and (slides or any(leg.slides for leg in legs(scene))):
        fail(
            scene,
            "relax.method",
            scene.relax.method,
            "cannot settle an end that slides",
            "'implicit' with an end tension",
        )


def _check_legs(scene: Scene) -> None:
    """Every leg must go somewhere, and no farther than it can."""
    limit, within = _reach(scene)
    path = [("push.start", scene.push.control, scene.push.start)]
    path += [(leg.key, leg.control, leg.stop) for leg in legs(scene)]
    if scene.clamps.end_shortening is not None:
        path.append(("clamps.end_shortening", SHORTENING, scene.clamps.end_shortening))
    for key, control, value in path:
        if not HELD[control].holds(value):
            fail(scene, key, value, "is out of range", HELD[control].allowed)
        if control == SHORTENING and value >= limit:
            fail(scene, key, value, "is a push past what the rod can give", within)
    _check_turns(scene, [scene.push.start, *scene.push.stop])
    for (begin, stop), leg in zip(ways(scene), legs(scene), strict=True):
        least = LEAST_STEP * max(1.0, abs(stop), 0.0 if math.isnan(begin) else abs(begin))
        if leg.max_step < least:
            key = leg.key.partition(".stop")[0] + ".max_step"
            fail(scene, key, leg.max_step, "is lost in rounding", f"{least:.3g} and above")


def _check_landings(scene: Scene) -> None:
    """Every landing must lie on the way."""
    low, high = covered_range(scene)
    _check_each(scene, "push.at", scene.push.at, low, high)
    for n, step in enumerate(scene.steps):
        key = f"steps[{n}]"
        stops = [way for way, leg in zip(ways(scene), legs(scene), strict=True)
                 if leg.key.startswith(f"{key}.")]  # fmt: skip
        values = [value for way in stops for value in way]
        unknown = any(math.isnan(value) for value in values)
        low, high = (-math.inf, math.inf) if unknown else (min(values), max(values))
        _check_each(scene, f"{key}.at", step.at, low, high)


def _check_each(
    scene: Scene, key: str, landings: tuple[float, ...], low: float, high: float
) -> None:
    for i, value in enumerate(landings):
        if not low <= value <= high:
            reach = f"from {write_quantity(low)} to {write_quantity(high)}, what the push covers"
            fail(scene, f"{key}[{i}]", value, "is never reached", reach)
        if i and value == landings[i - 1]:  # they are in order
            fail(scene, f"{key}[{i}]", value, "is given twice", "each landing once")


def covered_range(scene: Scene) -> tuple[float, float]:
    """The least and the largest value of ``push.control`` up to the last ``push.stop``."""
    points = (scene.push.start, *scene.push.stop)
    return min(points), max(points)


def _check_turns(scene: Scene, points: list[float]) -> None:
    steps = [after - before for before, after in pairwise(points)]
    for i, step in enumerate(steps):
        key = "push.stop" if len(steps) == 1 else f"push.stop[{i}]"
        if step == 0.0:
            fail(
                scene,
                key,
                points[i + 1],
                "does not move the clamp",
                f"another {HELD[scene.push.control].words}",
            )
        if i > 0 and step * steps[i - 1] > 0.0:
            turn = "turning points that go up and down in turn (use push.at to land in between)"
            fail(scene, key, points[i + 1], "goes on the same way as the one before", turn)
