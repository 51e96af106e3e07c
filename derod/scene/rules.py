"""What each key of a scene may hold, alone and together with the others."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise
from typing import Any, NoReturn

from derod.errors import SceneError
from derod.scene.plan import LEAST_STEP
from derod.scene.quantities import read_integer, read_number, read_quantity, write_quantity
from derod.scene.tables import Scene

LARGEST = 1e6  # D; beyond it sums of energies have no digits left
STRONGEST = 1e9  # of stiffnesses and forces: any unit K0 will do
WEAKEST = 1e-12
CLAMP_CLEARANCE = 0.9
METHODS = ("implicit", "elliptic", "fire", "kinetic")


@dataclass(frozen=True, slots=True)
class Key:
    """How one value is read: ``read`` raises ValueError with a reason, ``holds`` judges."""

    read: Callable[[Any], Any]
    holds: Callable[[Any], bool]
    allowed: str
    many: str = "no"  # "no": one value; "or": one value or a list; "list": a list


def _bending(value: object) -> float:
    if isinstance(value, list):
        raise ValueError("asks for two bending stiffnesses, which are not yet supported")
    return read_number(value)


def _weight(value: object) -> float:
    weight = read_number(value)
    if weight != 0.0:
        raise ValueError("asks for a drop with weight, which is not yet supported")
    return weight


def _method(value: object) -> str:
    if not isinstance(value, str) or value not in METHODS:
        raise ValueError("is no relaxation method")
    return value


def _switch(value: object) -> bool:
    if not isinstance(value, bool):
        raise ValueError("is neither true nor false")
    return value


def _any(_: object) -> bool:
    return True


_end_shortening = Key(read_quantity, lambda x: x > 0.0, "an end-shortening above 0, e.g. '2.8 pi'")

KEYS: dict[str, dict[str, Key]] = {
    "rod": {
        "length": Key(
            read_quantity,
            lambda x: 0.0 < x <= LARGEST,
            "a length above 1, the diameter of the drop, and up to 1e6",
        ),
        "bending": Key(_bending, lambda x: WEAKEST <= x <= STRONGEST, "a number from 1e-12 to 1e9"),
        "twisting": Key(read_number, lambda x: 0.0 <= x <= STRONGEST, "a number from 0 to 1e9"),
    },
    "drop": {
        "capillary_force": Key(
            read_number, lambda x: WEAKEST <= x <= STRONGEST, "a number from 1e-12 to 1e9"
        ),
        "wall_strength": Key(
            read_number, lambda x: WEAKEST <= x <= STRONGEST, "a number from 1e-12 to 1e9"
        ),
        "wall_softness": Key(
            read_quantity, lambda x: WEAKEST <= x <= 1.0, "a number from 1e-12 to 1"
        ),
        "weight": Key(_weight, _any, "0"),
    },
    "clamps": {
        "end_rotation": Key(
            read_quantity, lambda x: abs(x) <= LARGEST, "an angle in radians, e.g. '2 pi'"
        ),
    },
    "push": {
        "start": _end_shortening,
        "stop": Key(
            _end_shortening.read,
            _end_shortening.holds,
            _end_shortening.allowed + ", or a list of turning points",
            many="or",
        ),
        "at": Key(
            _end_shortening.read,
            _end_shortening.holds,
            "a list of end-shortenings above 0, e.g. ['0.1 pi', 1.5]",
            many="list",
        ),
        "max_step": Key(
            read_quantity, lambda x: 0.0 < x <= LARGEST, "a step of the end-shortening above 0"
        ),
    },
    "mesh": {
        "edges": Key(read_integer, lambda n: 12 <= n <= 100_000, "an integer from 12 to 100000"),
        "wetted_share": Key(read_number, lambda x: 0.3 <= x <= 0.8, "a share from 0.3 to 0.8"),
        "layer": Key(read_number, lambda x: 0.01 <= x <= 1e3, "a number from 0.01 to 1000"),
        "inner_grading": Key(read_number, lambda x: 0.0 <= x <= 3.0, "a number from 0 to 3"),
    },
    "relax": {
        "method": Key(_method, _any, "'implicit', 'fire' or 'kinetic'"),
        "tolerance": Key(
            read_number, lambda x: 1e-15 <= x <= 1e-2, "a residual force from 1e-15 to 1e-2"
        ),
    },
    "noise": {
        "seed": Key(read_integer, lambda n: 0 <= n < 2**63, "an integer from 0 to 2^63 - 1"),
        "amplitude": Key(read_quantity, lambda x: 0.0 <= x <= 1.0, "a length from 0 to 1"),
    },
    "model": {
        "dimension": Key(read_integer, lambda n: n in (2, 3), "2 or 3"),
        "drop": Key(_switch, _any, "true or false"),
    },
}
QUANTITIES = {
    (table, name)
    for table, keys in KEYS.items()
    for name, key in keys.items()
    if key.read is read_quantity
}


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
    push = scene.push
    length = scene.rod.length
    if scene.drop is None:
        limit, within = length, f"below {length:g}, where the clamps meet"
    else:
        if length <= 1.0:
            _fail(scene, "rod.length", length, "is out of range", KEYS["rod"]["length"].allowed)
        limit = largest_end_shortening(length)
        within = (
            f"below {limit:g}: with a rod of length {length:g} the clamps would stand "
            f"closer than the menisci (the rod runs out near {length - 1.0:g})"
        )
    legs = [("push.start", push.start)]
    legs += [
        (f"push.stop[{i}]" if len(push.stop) > 1 else "push.stop", stop)
        for i, stop in enumerate(push.stop)
    ]
    for key, value in legs:
        if value >= limit:
            _fail(scene, key, value, "is a push past what the rod can give", within)
    _check_turns(scene, [value for _, value in legs])
    least = LEAST_STEP * max(1.0, *(value for _, value in legs))
    if push.max_step < least:
        _fail(
            scene, "push.max_step", push.max_step, "is lost in rounding", f"{least:.3g} and above"
        )
    low, high = covered_range(scene)
    for i, value in enumerate(push.at):
        if not low <= value <= high:
            reach = f"from {write_quantity(low)} to {write_quantity(high)}, what the push covers"
            _fail(scene, f"push.at[{i}]", value, "is never reached", reach)
        if i and value == push.at[i - 1]:  # they are in order
            _fail(scene, f"push.at[{i}]", value, "is given twice", "each landing once")
    if scene.model.dimension == 2 and scene.clamps.end_rotation != 0.0:
        _fail(
            scene,
            "clamps.end_rotation",
            scene.clamps.end_rotation,
            "turns the rod out of its plane",
            "0 with model.dimension = 2",
        )


def covered_range(scene: Scene) -> tuple[float, float]:
    """The least and the largest end-shortening of the push, in D."""
    points = (scene.push.start, *scene.push.stop)
    return min(points), max(points)


def _check_turns(scene: Scene, points: list[float]) -> None:
    steps = [after - before for before, after in pairwise(points)]
    for i, step in enumerate(steps):
        key = "push.stop" if len(steps) == 1 else f"push.stop[{i}]"
        if step == 0.0:
            _fail(scene, key, points[i + 1], "does not move the clamp", "another end-shortening")
        if i > 0 and step * steps[i - 1] > 0.0:
            turn = "turning points that go up and down in turn (use push.at to land in between)"
            _fail(scene, key, points[i + 1], "goes on the same way as the one before", turn)


def _fail(scene: Scene, key: str, value: float, problem: str, allowed: str) -> NoReturn:
    written = write_quantity(value)
    raise SceneError(
        problem, file=scene.path, key=key, value=value, allowed=allowed, written=written
    )
