"""What is simulated: scene files read into frozen, checked objects."""

from derod.scene import showing
from derod.scene.reading import build_scene, load_scene, parse_scene
from derod.scene.tables import Clamps, Drop, Mesh, Model, Noise, Push, Relax, Rod, Scene
from derod.scene.writing import Group, dimensionless_groups, dump_scene

__all__ = [
    "Clamps",
    "Drop",
    "Group",
    "Mesh",
    "Model",
    "Noise",
    "Push",
    "Relax",
    "Rod",
    "Scene",
    "build_scene",
    "dimensionless_groups",
    "dump_scene",
    "load_scene",
    "parse_scene",
]

Scene.__repr__ = showing.text  # type: ignore[method-assign, assignment]
Scene._repr_html_ = showing.html  # type: ignore[attr-defined]
