"""What ``derod check`` says of a scene, in lines of text."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from derod.errors import SceneError
from derod.scene.directors import check_pushable
from derod.scene.experiment import Group, left_out, si_quantities
from derod.scene.tables import Scene
from derod.scene.writing import dimensionless_groups

DIGITS = 8  # enough for 1e-6 of any value


def pushable_words(scene: Scene) -> str:
    """Whether the scene can be pushed."""
    try:
        check_pushable(scene)
    except SceneError as error:
        return f"a scene that cannot be pushed yet: {error.key} {error.problem}"
    return "a scene that can be pushed"


def check_lines(scene: Scene) -> Iterator[str]:
    """The dimensionless groups; with [material] also its SI quantities, and what is left out."""
    yield from _lines(dimensionless_groups(scene))
    if scene.material is None:
        return
    yield "in SI"
    yield from _lines(si_quantities(scene, scene.material))
    yield "left out by the model"
    yield from _lines(left_out(scene.material))


def _lines(groups: Iterable[Group]) -> Iterator[str]:
    shown = [(group, _number(group)) for group in groups]
    width = max(14, *(len(number) + 1 for _, number in shown))
    for group, number in shown:
        yield f"  {group.symbol:18}{number:{width}}{group.meaning}"


def _number(group: Group) -> str:
    error = f" +- {group.error:.2g}" if group.error else ""
    return f"{group.value:.{DIGITS}g}{error} {group.unit}".rstrip()
