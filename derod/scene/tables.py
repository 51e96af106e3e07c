"""The tables of a scene file as frozen objects.

Lengths are in D (the drop's diameter), forces in K0/D^2, stiffnesses in K0, energies in K0/D,
angles in radians; those of ``Material`` alone are in SI.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import msgspec

from derod.scene.units import Measured

ROUND = 1e-7
"""On |K2/K1 - 1|: below it a section is round."""


class Table(msgspec.Struct, frozen=True, kw_only=True):
    """One table of a scene; its fields are the keys of the file."""


class Material(Table, frozen=True, kw_only=True):
    """The experiment in SI; ``derod.scene.material`` turns it into the numbers of the other tables."""

    young_modulus: Measured
    """E, Pa."""
    poisson_ratio: Measured | None = None
    """nu; None where ``rod.twisting`` is given."""
    diameter: Measured | None = None
    """d, m, of a circular section."""
    width: Measured | None = None
    """w, m, the longer side of a rectangular section."""
    height: Measured | None = None
    """h, m, its shorter side, the way it bends easily."""
    surface_tension: Measured
    """gamma, N/m, of the liquid in air."""
    contact_angle: Measured
    """theta, rad, of the liquid on the rod, below a right angle."""
    drop_diameter: Measured
    """D, m."""
    length: Measured | None = None
    """L, m, between the clamps; None where ``rod.length`` is given in D."""
    drop_density: Measured | None = None
    """Of the liquid, kg/m^3: only for what the model leaves out."""
    rod_density: Measured | None = None
    """kg/m^3: only for what the model leaves out."""
    gravity: Measured = Measured(9.80665)
    """g, m/s^2; the standard one."""


class Rod(Table, frozen=True, kw_only=True):
    """The elastic rod between the two clamps."""

    length: float
    """l = L/D, the length between the clamps."""
    bending: float
    """K/K0 of an isotropic section; K1/K0, of bending about d_1, where there are two."""
    bending_2: float | None = None
    """K2/K0, of bending about d_2: the second of ``rod.bending = [K1, K2]``. None: K1."""
    twisting: float
    """k3 = K3/K0."""
    natural_curvature: tuple[float, float] | None = None
    """(k_1, k_2), D^-1: the curvatures about d_1 and d_2 of the unloaded rod. None: it is straight."""
    natural_twist: float | None = None
    """tau_0, rad/D, of the unloaded rod. None: it has none."""


def written_fields(table: Table) -> dict[str, Any]:
    """The keys of a table as a file has them, without those that are None."""
    given = {name: getattr(table, name) for name in table.__struct_fields__}
    if isinstance(table, Rod) and table.bending_2 is not None:
        given["bending"] = (table.bending, given.pop("bending_2"))
    if isinstance(table, Clamps) and table.directors is not None:
        del given["end_rotation"]  # their difference
    return {name: value for name, value in given.items() if value is not None}


class Drop(Table, frozen=True, kw_only=True):
    """The liquid drop: capillary pull at the menisci and a soft wall inside."""

    capillary_force: float
    """f_gamma, K0/D^2: the energy gained for a unit length of rod wetted."""
    wall_strength: float
    """v0, K0/D^2, in v(r) = v0 / (1 + rho - 2 r)."""
    wall_softness: float
    """rho, D: the wall diverges at r = (1 + rho)/2."""
    weight: float = 0.0
    """Of the drop, K0/D^2."""


class Clamps(Table, frozen=True, kw_only=True):
    """The two clamps, facing each other on one axis."""

    end_rotation: float = 0.0
    """R, rad: how far the end clamp is turned about the axis; with ``directors`` alpha_L - alpha_0."""
    directors: tuple[float, float] | None = None
    """(alpha_0, alpha_L), rad: the angles from e_x to d_1 at both clamps, where a section has directions."""
    end_shortening: float | None = None
    """delta, D: held where another control pushes first; None where nothing holds it."""
    end_tension: float | None = None
    """T, K0/D^2, of a dead load: the end clamp slides along the axis under it. None: it is held."""


class Push(Table, frozen=True, kw_only=True):
    """The path of the control, in its unit: D for the end-shortening delta."""

    control: str = "end_shortening"
    """What is changed: a name of ``derod.scene.controls``."""
    start: float = 0.001 * math.pi
    """The first increment; for other controls than the end-shortening, what stands in their table."""
    stop: tuple[float, ...] = ()
    """The turning points, the last of which ends the push. One number in the file gives a tuple."""
    at: tuple[float, ...] = ()
    """Values to land on exactly, in increasing order."""
    max_step: float = 0.02 * math.pi
    """The largest increment; for other controls the one of ``derod.scene.controls``."""
    locate: bool | None = None
    """Whether the places of folds and bifurcations are found between increments; None: where
    another control than the end-shortening pushes."""
    bend: str = "down"
    """Which way the rod bends at first: "down", so that a heavy drop hangs, or "up", where the coil is wound
    without the weight and then loaded."""


class Step(Table, frozen=True, kw_only=True):
    """One of ``[[steps]]``: what the push goes on with when it has come to ``push.stop``."""

    control: str
    """What is changed."""
    stop: tuple[float, ...]
    """Where to, with turning points on the way."""
    at: tuple[float, ...] = ()
    """Values to land on exactly, in increasing order."""
    max_step: float
    """The largest increment."""


class Mesh(Table, frozen=True, kw_only=True):
    """The discrete rod."""

    edges: int = 200
    """N; there are N + 1 nodes."""
    wetted_share: float = 0.65
    """Share of the edges inside the drop; the rest is halved between the ends."""
    layer: float = 0.5
    """Where the outer edges stay short beside a meniscus, in elastocapillary lengths sqrt(K0/f_gamma)."""
    inner_grading: float = 0.9
    """Logarithm of the longest inner edge, in the drop's middle, over the shortest."""


class Relax(Table, frozen=True, kw_only=True):
    """How an increment is settled."""

    method: str = "implicit"
    """"implicit", "elliptic", "fire" or "kinetic"."""
    tolerance: float = 1e-9
    """On the residual force, in bending / D^2, before the scaling with the mesh."""


class Noise(Table, frozen=True, kw_only=True):
    """The seeded disturbance that breaks symmetries."""

    seed: int = 0
    amplitude: float = 1e-3
    """D; zero leaves symmetric data symmetric."""


class Model(Table, frozen=True, kw_only=True):
    """What is modelled."""

    dimension: int = 3
    """3, or 2 for a rod that stays in its plane."""
    drop: bool = True
    """False for a rod without a drop, the clamped elastica; there is no table ``drop`` then."""


class Scene(msgspec.Struct, frozen=True, kw_only=True, eq=False):
    """Everything a push needs to know. Two scenes are equal when all their tables are."""

    material: Material | None = None
    """Where the numbers of ``rod`` and ``drop`` come from, if they come from an experiment."""
    rod: Rod
    drop: Drop | None
    clamps: Clamps = Clamps()
    push: Push
    steps: tuple[Step, ...] = ()
    """What follows, with other controls."""
    mesh: Mesh = Mesh()
    relax: Relax = Relax()
    noise: Noise = Noise()
    model: Model = Model()
    path: str | None = None
    """The file it came from, for messages."""

    @property
    def has_frames(self) -> bool:
        """Whether edges need frames: two bending stiffnesses or a natural shape, in space.

        Stiffnesses that differ by less than ``ROUND`` leave a turn about the axis that is neutral to
        rounding; such a rod is a round one.
        """
        rod = self.rod
        two = rod.bending_2 is not None and abs(rod.bending_2 / rod.bending - 1) > ROUND
        shaped = any(rod.natural_curvature or ()) or bool(rod.natural_twist)
        return self.model.dimension == 3 and (two or shaped)

    @property
    def text(self) -> str:
        """The scene as canonical TOML; parsing it gives an equal scene."""
        from derod.scene.writing import dump_scene

        return dump_scene(self)

    def replace(self, changes: Mapping[str, Any]) -> Scene:
        """A new, checked scene with e.g. ``{"mesh.edges": 150, "push.stop": "0.6 pi"}`` changed.

        Landings (``push.at``) that a changed ``push.stop`` no longer reaches are dropped.
        Raises SceneError, as reading a file with these values would.
        """
        from derod.scene.reading import replace_keys

        return replace_keys(self, changes)

    def require_drop(self) -> Drop:
        """The drop, for what makes no sense without one; raises SceneError where there is none."""
        if self.drop is None:
            from derod.errors import SceneError

            raise SceneError(
                "has no place here: this needs a drop",
                file=self.path,
                key="model.drop",
                value=False,
                allowed="true",
            )
        return self.drop

    def tables(self) -> dict[str, Table]:
        """The tables by name, in the order of the file; ``steps`` come after ``push``."""
        names = (name for name in self.__struct_fields__ if name not in ("path", "steps"))
        return {name: getattr(self, name) for name in names if getattr(self, name) is not None}

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Scene):
            return NotImplemented
        return self.tables() == other.tables() and self.steps == other.steps

    def __hash__(self) -> int:
        return hash((self.steps, *self.tables().values()))
