"""A small push that calls what pushes of its kind call: for compiling before it is needed.

Kernels are compiled for the number of dimensions, for sections with directions or without and, beside those
of implicit steps, for the method; not for sizes or stiffnesses. So every scene has the kernels of a small,
easy scene of its kind.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from derod.scene import Scene
from derod.scene.reading import build_scene

if TYPE_CHECKING:
    from derod.pushing.driver import Push
    from derod.rod.state import State

EDGES = 16
METHODS = ("implicit", "elliptic", "fire", "kinetic")


class Variant(NamedTuple):
    """What kernels depend on."""

    dimension: int
    drop: bool
    method: str
    frames: bool = False  # of a section with directions

    @property
    def name(self) -> str:
        """The variant in a few words, as "in space, implicit"."""
        place = "in space" if self.dimension == 3 else "in the plane"
        section = ", with directions" if self.frames else ""
        return f"{place}{'' if self.drop else ' without drop'}{section}, {self.method}"


ROUND = tuple(
    Variant(dimension, drop, method)
    for method in METHODS
    for dimension in (3, 2)
    for drop in (True, False)
)
VARIANTS = (*ROUND, Variant(3, True, "implicit", True), Variant(3, False, "implicit", True))


def variant_of(scene: Scene) -> Variant:
    """The variant of a scene."""
    drop, method = scene.drop is not None, scene.relax.method
    return Variant(scene.model.dimension, drop, method, scene.has_frames)


def small_scene(variant: Variant) -> Scene:
    """A small, easy scene of the variant's kind, relaxed implicitly."""
    tables: dict[str, dict[str, object]] = {
        "rod": {"length": 10.0, "bending": 1.0, "twisting": 0.9},
        "push": {"start": "0.001 pi", "stop": "0.006 pi", "max_step": "0.02 pi"},
        "mesh": {"edges": EDGES},
        "model": {"dimension": variant.dimension, "drop": variant.drop},
        "noise": {"seed": 1},
    }
    if variant.frames:
        tables["rod"]["bending"] = [1.0, 2.0]
        tables["clamps"] = {"directors": [0.0, 0.0]}
    if variant.drop:
        tables["drop"] = {"capillary_force": 20.0, "wall_strength": 2e-4, "wall_softness": 0.1}
    return build_scene(tables)


def first_increments(variant: Variant) -> None:
    """Settle the first state and some increments; take a batch of the method's steps."""
    push = first_push(variant)
    push.run()
    take_steps(push, variant.method, descend=False)


def instabilities(variant: Variant) -> None:
    """Go down from a disturbed state, and leave a state by a kick, as at folds and unstable states."""
    from derod.pushing.descent import disturbed
    from derod.pushing.kicks import kick

    push = first_push(variant)
    push.run()
    state = settled(push)
    descender = push.increments.descender()
    start = disturbed(state, descender.noise)
    kick(push.system, state.copy(), 1e-3, descender.noise.start(0, state.q.shape))
    descender.descend(start)
    take_steps(push, variant.method, descend=True)


def first_push(variant: Variant) -> Push:
    """A small push that has begun."""
    from derod.pushing.driver import Push  # imports the kernels

    push = Push(small_scene(variant), [])
    push.begin()
    return push


def settled(push: Push) -> State:
    """The state that a push has reached."""
    assert push.here is not None
    return push.here.state


def take_steps(push: Push, method: str, *, descend: bool) -> None:
    """Take one batch of a method's steps from a push's state."""
    from derod.equilibrium.methods import make_relaxer

    relaxer = make_relaxer(method)
    tolerance = max(push.system.tolerance, relaxer.finest)
    amplitude = push.scene.noise.amplitude
    state = settled(push).copy()
    relaxer.begin(push.system, state, tolerance, descend=descend, kick=amplitude)
    relaxer.advance()
