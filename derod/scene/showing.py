"""What a scene looks like at a prompt and in a notebook."""

from __future__ import annotations

from derod.scene.axis import AXES
from derod.scene.program import legs
from derod.scene.tables import Scene
from derod.scene.writing import dimensionless_groups


def text(scene: Scene) -> str:
    """A line: the rod, the drop and the push."""
    push, drop = scene.push, scene.drop
    wet = "no drop" if drop is None else (
        f"f_gamma = {drop.capillary_force:g}, v0 = {drop.wall_strength:g}, rho = {drop.wall_softness:g}"
    )  # fmt: skip
    way = ", then ".join(
        f"{AXES[leg.control].name} to {AXES[leg.control].both(leg.stop)}" for leg in legs(scene)
    )
    name = "" if scene.path is None else f" {scene.path}"
    return (
        f"<scene{name}: l = {scene.rod.length:g}, {wet}, from "
        f"{AXES[push.control].both(push.start)}, {way}, {scene.mesh.edges} edges>"
    )


def html(scene: Scene) -> str:
    """The dimensionless groups as a table, and the text folded away."""
    from html import escape

    from derod.scene.html import html_table

    groups = [
        (group.symbol, f"{group.value:.6g} {group.unit}".strip(), group.meaning)
        for group in dimensionless_groups(scene)
    ]
    table = html_table(text(scene)[1:-1], ("", "", "meaning"), groups)
    return f"{table}<details><summary>TOML</summary><pre>{escape(scene.text)}</pre></details>"
