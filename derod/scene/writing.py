"""From a Scene back to text: canonical TOML, and its dimensionless groups."""

from __future__ import annotations

import math
from typing import Any

from derod.scene.experiment import Group, group_errors
from derod.scene.material import derived, plain_material
from derod.scene.plain import comes_from
from derod.scene.quantities import write_quantity
from derod.scene.rules import QUANTITIES
from derod.scene.tables import Material, Rod, Scene, Step, written_fields
from derod.scene.together import covered_range


def dump_scene(scene: Scene) -> str:
    """Canonical TOML of ``scene``, every key written out; ``parse_scene`` gives an equal scene.

    What [material] gives stands in [rod] and [drop] as comments.
    """
    blocks = []
    known = {} if scene.material is None else derived(scene.material)
    for table, struct in scene.tables().items():
        lines = [f"[{table}]"]
        if isinstance(struct, Material):
            lines += [f"{name} = {_toml(x, False)}" for name, x in plain_material(struct).items()]
        else:
            for name, value in written_fields(struct).items():
                line = f"{name} = {_toml(value, (table, name) in QUANTITIES)}"
                given = comes_from(known, table, name, value)
                lines.append(f"# {line}  # from [material]" if given else line)
        blocks.append("\n".join(lines) + "\n")
        if table == "push":
            blocks += [_step(step) for step in scene.steps]
    return "\n".join(blocks)


def _step(step: Step) -> str:
    """One of [[steps]]."""
    names = step.__struct_fields__
    lines = [
        f"{name} = {_toml(getattr(step, name), ('push', name) in QUANTITIES)}" for name in names
    ]
    return "\n".join(["[[steps]]", *lines]) + "\n"


def _toml(value: Any, angle: bool) -> str:
    if isinstance(value, tuple):
        return "[" + ", ".join(_toml(item, angle) for item in value) + "]"
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, str):
        return f'"{value}"'  # names of methods and quantities with units, nothing to escape
    return write_quantity(value) if angle and isinstance(value, float) else repr(value)


def _stiffness_groups(rod: Rod) -> list[Group]:
    groups = [Group("k3/K", rod.twisting / rod.bending, "twisting over bending stiffness")]
    if rod.bending_2 is not None:
        meaning = "bending stiffness about d_2 over that about d_1, which is K"
        groups.insert(0, Group("K2/K", rod.bending_2 / rod.bending, meaning))
    return groups


def dimensionless_groups(scene: Scene) -> list[Group]:
    """The numbers that decide what the rod of ``scene`` does, D and K being its units."""
    rod, drop = scene.rod, scene.drop
    low, high = covered_range(scene)
    if drop is None:
        return [
            *_stiffness_groups(rod),
            Group(
                "R/(2 pi)", scene.clamps.end_rotation / (2.0 * math.pi), "turns of the end clamp"
            ),
            Group("delta_min/l", low / rod.length, "least end-shortening over length"),
            Group("delta_max/l", high / rod.length, "largest end-shortening over length"),
        ]
    pull = drop.capillary_force / rod.bending
    groups = [
        Group("l", rod.length, "rod length over drop diameter"),
        *_stiffness_groups(rod),
        Group("f_gamma D^2/K", pull, "capillary force; above 2 a coil on the wall pays off"),
        Group("L_EC/D", 1.0 / math.sqrt(pull), "elastocapillary length sqrt(K/f_gamma)"),
        Group("v0 D^2/K", drop.wall_strength / rod.bending, "strength of the wall"),
        Group("rho", drop.wall_softness, "softness of the wall, which diverges at (1 + rho)/2"),
        Group("v0/(rho f_gamma)", drop.wall_strength / drop.wall_softness / drop.capillary_force,
              "wall energy at a meniscus over the capillary force"),
        Group("R/(2 pi)", scene.clamps.end_rotation / (2.0 * math.pi), "turns of the end clamp"),
        Group("delta_min/pi", low / math.pi, "least end-shortening"),
        Group("delta_max/pi", high / math.pi, "largest end-shortening, about the number of loops"),
        Group("delta_end/pi", (rod.length - 1.0) / math.pi, "where the outer rod about runs out"),
        Group("t_coil", drop.capillary_force - 2.0 * rod.bending,
              "tension of a coil on a hard wall, K0/D^2"),
        Group("t_plateau",
              drop.capillary_force - 2.0 * rod.bending / (1.0 + drop.wall_softness) ** 2,
              "tension of a coil at (1 + rho)/2 as v0 -> 0, K0/D^2"),
    ]  # fmt: skip
    errors = {} if scene.material is None else group_errors(scene, scene.material)
    return [group._replace(error=errors.get(group.symbol, 0.0)) for group in groups]
