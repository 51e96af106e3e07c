"""Paint a tube in a drop: orthographic, sorted by depth, shaded; vector graphics throughout.

Every tube is cut into quadrilaterals that are painted back to front as one PolyCollection; the
drop is a shaded disc behind the tube, and what lies deep in it takes on its colour.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from matplotlib.colors import to_rgb
from matplotlib.patches import Circle, Polygon, Rectangle

from derod.record.geometry import point_at, unit
from derod.views.plots.reading import Shape
from derod.views.plots.style import Theme

SIDES = 14
RADIUS = 0.021  # D
FINEST = 0.012  # D between rings
LIGHT = unit(np.array([-0.45, 0.75, 0.6]))  # in view: right, up, toward the eye
DISCS = 48
TALL = 0.795  # of the reach to the sides, up and down


@dataclass(frozen=True)
class View:
    """An orthographic eye: rows are right, up and toward the eye, in the frame of the rod."""

    axes: np.ndarray  # (3, 3)

    def see(self, points: np.ndarray) -> np.ndarray:
        """Points (..., 3) as the eye has them."""
        return points @ self.axes.T


def view(toward: tuple[float, float, float], right: tuple[float, float, float] = (0, 0, 1)) -> View:
    """The eye that looks from ``toward`` at the drop, with ``right`` (about) to its right."""
    back = unit(np.array(toward, dtype=float))
    side = np.array(right, dtype=float)
    side = unit(side - (side @ back) * back)
    return View(np.stack([side, np.cross(back, side), back]))


def turned(angle: float, lift: float = 0.35) -> View:
    """The eye turned by ``angle`` about the clamp axis, lifted to it by ``lift``: the axis lies
    level.
    """
    cos, sin = np.cos(lift), np.sin(lift)
    return view((cos * np.cos(angle), cos * np.sin(angle), -sin))


def finer(points: np.ndarray, s: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """A smooth curve through the nodes (N+1, 3), closer than FINEST: (k, 3) and its arc length."""
    from scipy.interpolate import CubicSpline

    count = np.maximum(np.ceil(np.diff(s) / FINEST).astype(int), 1)
    places = np.concatenate(
        [s[i] + (s[i + 1] - s[i]) * np.arange(n) / n for i, n in enumerate(count)]
    )
    places = np.append(places, s[-1])
    return CubicSpline(s, points)(places), places


@dataclass(frozen=True)
class Tube:
    """Quadrilaterals of a tube in view: corners (m, 4, 3), normals (m, 3), arc length (m,)."""

    corners: np.ndarray
    normals: np.ndarray
    arc_length: np.ndarray


def tube_in_view(points: np.ndarray, s: np.ndarray, radius: float) -> Tube:
    """The half of a tube that faces the eye, around points (k, 3) in view.

    Rings are laid out from the direction that faces the eye, so that no frame need be transported.
    """
    tangent = unit(np.gradient(points, axis=0))
    eye = np.array([0.0, 0.0, 1.0])
    facing = eye - tangent * tangent[:, 2:]
    weak = np.linalg.norm(facing, axis=1) < 1e-3
    facing[weak] = [0.0, 1.0, 0.0]
    facing = unit(facing - tangent * np.sum(facing * tangent, axis=1, keepdims=True))
    side = np.cross(tangent, facing)
    angle = np.linspace(-np.pi / 2, np.pi / 2, SIDES)[:, None]
    normals = np.cos(angle) * facing[:, None] + np.sin(angle) * side[:, None]
    ring = points[:, None] + radius * normals
    corners = np.stack([ring[:-1, :-1], ring[1:, :-1], ring[1:, 1:], ring[:-1, 1:]], axis=2)
    middle = normals[:-1, :-1] + normals[1:, :-1] + normals[1:, 1:] + normals[:-1, 1:]
    where = np.repeat(0.5 * (s[1:] + s[:-1]), SIDES - 1)
    return Tube(corners.reshape(-1, 4, 3), unit(middle.reshape(-1, 3)), where)


def shade(base: np.ndarray, normals: np.ndarray, depth: np.ndarray, theme: Theme) -> np.ndarray:
    """Colours (m, 3): lit from the upper left, fading into the paper with ``depth`` (m,) in
    0..1.
    """
    lit = np.clip(normals @ LIGHT, 0.0, 1.0)[:, None]
    half = unit(LIGHT + np.array([0.0, 0.0, 1.0]))
    gloss = np.clip(normals @ half, 0.0, 1.0)[:, None] ** 30
    color = base * (0.38 + 0.68 * lit) + 0.45 * gloss
    paper = np.array(to_rgb(theme.paper))
    far = 0.5 * np.clip(depth, 0.0, 1.0)[:, None]
    return np.asarray(np.clip(color * (1 - far) + paper * far, 0.0, 1.0))


def paint_shape(
    axes: Axes,
    shape: Shape,
    eye: View,
    theme: Theme,
    color: str | np.ndarray,
    radius: float = RADIUS,
    reach: float = 0.78,
) -> None:
    """Paint a configuration about its drop's centre: tube, translucent drop, meniscus points.

    ``color`` is one colour, or one for each node (N+1, 3). What lies beyond ``reach`` (D) is cut
    off. Without a drop only the tube and the clamps are there.
    """
    points, s = finer(shape.positions - shape.center, shape.arc_length)
    seen = eye.see(points)
    kept = np.abs(seen[:, 0]) < reach + 0.25
    first, last = np.flatnonzero(kept)[[0, -1]]
    seen, s = seen[first : last + 1], s[first : last + 1]
    if shape.wet:
        paint_drop(axes, theme)
        if np.isfinite(shape.wall):
            edge = Circle(
                (0, 0), shape.wall, facecolor="none", edgecolor=theme.rim, linewidth=0.7, alpha=0.7
            )
            edge.set(linestyle=(0, (1, 2)), zorder=1.9, gid="wall")
            axes.add_patch(edge)
    tube = tube_in_view(seen, s, radius)
    if isinstance(color, str):
        base = np.broadcast_to(np.array(to_rgb(color)), tube.normals.shape)
    else:
        base = np.stack([np.interp(tube.arc_length, shape.arc_length, c) for c in color.T], axis=-1)
    height = tube.corners[:, :, 2].mean(axis=1)
    colors = shade(base, tube.normals, 0.45 - height, theme)
    inside = (tube.arc_length > shape.menisci[0]) & (tube.arc_length < shape.menisci[1])
    water = np.array(theme.water)
    behind = np.clip(0.5 - height, 0.0, 1.0)[:, None] * inside[:, None]
    colors = colors * (1 - 0.34 * behind) + water * 0.34 * behind
    order = np.argsort(height)
    quads = PolyCollection(
        list(tube.corners[order][:, :, :2]),
        facecolors=colors[order],
        edgecolors=colors[order],
        linewidths=0.25,
        zorder=5,
        gid="tube",
    )
    axes.add_collection(quads)
    for s_m in shape.menisci if shape.wet else ():
        at = eye.see(meniscus(shape, s_m)[None])[0]
        paint_bead(axes, at, 1.55 * radius, theme)
    for end in (0, -1):
        at = eye.see((shape.positions[end] - shape.center)[None])[0]
        if abs(at[0]) < reach:
            paint_clamp(axes, at, radius, -1 if end == 0 else 1)
    axes.set_xlim(-reach, reach)
    axes.set_ylim(-TALL * reach, TALL * reach)
    axes.set_aspect("equal")
    axes.set_axis_off()


def meniscus(shape: Shape, s_m: float) -> np.ndarray:
    """A meniscus point (3,), from the drop's centre."""
    return point_at(shape.positions, shape.arc_length, s_m) - shape.drop_center


def paint_drop(axes: Axes, theme: Theme, radius: float = 0.5) -> None:
    """The drop: discs that add up to the shading of a sphere, a rim and a glint."""
    paper, water = np.array(to_rgb(theme.paper)), np.array(theme.water)
    dark = 0.5 * (paper + water)
    bright = dark + theme.glow * (np.ones(3) - dark)
    for k in range(DISCS):  # opaque: many faint layers would add up to rounding errors
        part = k / (DISCS - 1)
        weight = part * part * (3 - 2 * part)
        axes.add_patch(
            Circle(
                (-0.10 * part * radius, 0.16 * part * radius),
                radius * (1 - 0.85 * part),
                facecolor=dark + weight * (bright - dark),
                edgecolor="none",
                zorder=2 + 0.01 * part,
            )
        )
    rim = Circle((0, 0), radius, facecolor="none", edgecolor=theme.rim, linewidth=0.9, alpha=0.8)
    rim.set(zorder=2.5, gid="drop")
    axes.add_patch(rim)
    around = np.linspace(np.radians(112), np.radians(152), 40)
    outer = 0.90 * radius * np.stack([np.cos(around), np.sin(around)], axis=1)
    inner = (0.90 - 0.055 * np.sin(np.linspace(0, np.pi, 40)))[:, None] * radius
    inner = inner * np.stack([np.cos(around), np.sin(around)], axis=1)
    glint = Polygon(np.concatenate([outer, inner[::-1]]), facecolor="white", alpha=0.5, zorder=2.6)
    glint.set_edgecolor("none")
    axes.add_patch(glint)


def paint_clamp(axes: Axes, at: np.ndarray, radius: float, side: int) -> None:
    """A clamp at the rod's end, seen from the side; ``side`` is where it holds on."""
    block = Rectangle(
        (at[0] - (2.2 * radius if side < 0 else 0.0), at[1] - 2.6 * radius),
        2.2 * radius,
        5.2 * radius,
        facecolor="#9aa0ab",
        edgecolor="#50555f",
        linewidth=0.7,
    )
    block.set(zorder=5.5, gid="clamp")
    axes.add_patch(block)


def paint_bead(axes: Axes, at: np.ndarray, radius: float, theme: Theme) -> None:
    """A meniscus point."""
    bead = Circle(
        (float(at[0]), float(at[1])),
        radius,
        facecolor="#f2c14e",
        edgecolor="#6b4e00",
        linewidth=0.7,
    )
    bead.set(zorder=6 + 0.1 * at[2], gid="meniscus")
    axes.add_patch(bead)
    shine = Circle(
        (at[0] - 0.3 * radius, at[1] + 0.35 * radius), 0.3 * radius, facecolor="white", alpha=0.8
    )
    shine.set(edgecolor="none", zorder=6.05 + 0.1 * at[2])
    axes.add_patch(shine)
