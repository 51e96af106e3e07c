"""The coil turning as it packs, with the t(delta) curve drawing itself: GIF, or MP4 by ffmpeg."""

from __future__ import annotations

import os
import shutil
import subprocess
import tempfile
from collections.abc import Iterable, Iterator
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from derod.exits import UsageError
from derod.scene.axis import axes_of
from derod.views.export.output import check_target, write_file
from derod.views.plots.painter import paint_shape, turned
from derod.views.plots.reading import Shape, run_shape, run_shape_at
from derod.views.plots.shapes import REACH, coil_angle
from derod.views.plots.style import LABELS, THEMES, Theme, look

ENDINGS = ("gif", "mp4")
TURNS = 0.75  # of the eye about the clamps' axis, over the movie
HOLD = 0.12  # of the frames show the end
COLORS = 160  # of a GIF's palette
INCHES = 6.4  # wide, whatever the pixels: letters grow with the picture
LIMITS = {"frames": (2, 5000), "rate": (1, 50), "width": (160, 4096)}


def movie(
    run: Any,
    output: str | os.PathLike[str],
    *,
    frames: int = 120,
    rate: int = 20,
    width: int = 640,
    style: str = "dark",
    force: bool = False,
    progress: bool = False,
) -> None:
    """Write a movie of an open run: ``frames`` pictures, ``rate`` a second, ``width`` pixels wide.

    A file that is there is only replaced with ``force``. Raises UsageError.
    """
    path = Path(output)
    check_target(path, force, ENDINGS)
    for name, value in (("frames", frames), ("rate", rate), ("width", width)):
        low, high = LIMITS[name]
        if not low <= value <= high:
            raise UsageError(f"{name} = {value}: allowed: {low} to {high}")
    if style not in THEMES:
        raise UsageError(f"style = {style!r}: allowed: {', '.join(THEMES)}")
    if path.suffix.lower() == ".mp4" and shutil.which("ffmpeg") is None:
        raise UsageError(f"-o = {path}: there is no ffmpeg to make it; allowed: a .gif needs none")
    if not len(run):
        raise UsageError(f"{run.path or 'a run in memory'}: has no increment to draw")
    pictures: Iterable[np.ndarray] = paint(run, frames, width, THEMES[style])
    if progress:
        from tqdm import tqdm

        pictures = tqdm(pictures, "painting", frames, leave=False)
    make = mp4 if path.suffix.lower() == ".mp4" else gif
    write_file(path, make(list(pictures), rate), force)


def _strides(run: Any) -> np.ndarray:
    """How far each increment went (T-1,): of what drives the push; all alike where that changes."""
    axes = axes_of(run.scene)
    if len(axes) > 1:
        return np.ones(len(run) - 1)
    return np.asarray(np.abs(np.diff(run.table[axes[0].column])))


def moments(run: Any, frames: int) -> np.ndarray:
    """Increments (frames,) to show: evenly along the way of the end, then the last one held."""
    moving = max(round(frames * (1 - HOLD)), 2)
    way = np.concatenate([[0.0], np.cumsum(_strides(run))])
    path = [int(np.argmin(np.abs(way - x))) for x in np.linspace(0.0, way[-1], moving)]
    return np.array([*path, *[len(way) - 1] * max(frames - moving, 0)])


def paint(run: Any, frames: int, width: int, theme: Theme) -> Iterator[np.ndarray]:
    """The frames, each (height, width, 3) of bytes, width and height even."""
    width += width % 2
    height = 2 * round(0.23 * width)
    with rc_context(look(theme)):
        figure = Figure(figsize=(INCHES, INCHES * height / width), dpi=width / INCHES)
        canvas = FigureCanvasAgg(figure)
        delta = run.table["end_shortening"]
        begin = coil_angle(run_shape(run, float(delta[-1])))
        angles = begin + 2 * np.pi * TURNS * np.linspace(0, 1, frames)
        for i, angle in zip(moments(run, frames), angles, strict=True):
            draw_frame(figure, run, int(i), float(angle), theme)
            canvas.draw()
            yield np.asarray(canvas.buffer_rgba())[:, :, :3].copy()


def draw_frame(figure: Figure, run: Any, i: int, angle: float, theme: Theme) -> None:
    """One picture: increment ``i`` seen from ``angle`` (rad) about the clamps' axis, and the curve
    so far.
    """
    figure.clear()
    shape = run_shape_at(run, i)
    paint_coil(figure.add_axes((0.0, 0.0, 0.6, 1.0)), shape, theme, angle)
    draw_curve(figure.add_axes((0.685, 0.2, 0.285, 0.58)), run, i, theme)


def paint_coil(axes: Axes, shape: Shape, theme: Theme, angle: float) -> None:
    """The coil, seen from ``angle`` about the clamps' axis."""
    reach = 0.84 if shape.wet else 0.55 * float(np.ptp(shape.positions[:, 2]))
    eye = turned(angle, 0.28)
    paint_shape(axes, shape, eye, theme, theme.paths["3D"], 0.023 * reach / REACH, reach=reach)
    axes.set_ylim(-0.774 * reach, 0.774 * reach)


def draw_curve(axes: Axes, run: Any, i: int, theme: Theme) -> None:
    """t against delta/pi up to increment ``i``, and faintly beyond."""
    delta, t = run.table["end_shortening"] / np.pi, run.table["end_tension"]
    done = slice(0, i + 1)
    axes.plot(delta, t, color=theme.faint, linewidth=2.0, gid="whole")
    axes.plot(delta[done], t[done], color=theme.paths["3D"], linewidth=2.4, gid="done")
    axes.plot(
        delta[i], t[i], "o", markersize=9, color="#f2c14e", markeredgecolor="#6b4e00",
        gid="here", zorder=5,
    )  # fmt: skip
    span = max(float(t.max() - t.min()), 1e-3)
    axes.set_xlim(0, 1.04 * max(float(delta.max()), 1e-9))
    axes.set_ylim(min(0.0, float(t.min()) - 0.1 * span), max(float(t.max()) + 0.12 * span, 1e-3))
    axes.set_xlabel(LABELS["delta"])
    axes.set_ylabel(LABELS["end_tension"])
    axes.set_title(
        rf"$\delta$ = {delta[i]:.2f}$\,\pi\,D$" "\n" rf"$t = {t[i]:.2f}\,K_0/D^2$",
        fontsize=12,
        pad=8,
    )


def gif(pictures: list[np.ndarray], rate: int, colors: int = COLORS) -> bytes:
    """One palette for all frames, taken from the last, so that nothing flickers."""
    from PIL import Image

    images = [Image.fromarray(picture) for picture in pictures]
    palette = images[-1].quantize(colors, method=Image.Quantize.MEDIANCUT)
    frames = [image.quantize(palette=palette, dither=Image.Dither.NONE) for image in images]
    buffer = BytesIO()
    frames[0].save(
        buffer, "GIF", save_all=True, append_images=frames[1:], duration=1000 // rate, loop=0,
        optimize=True,
    )  # fmt: skip
    return buffer.getvalue()


def mp4(pictures: list[np.ndarray], rate: int) -> bytes:
    """By ffmpeg, in a form that browsers play."""
    height, width, _ = pictures[0].shape
    command = ["ffmpeg", "-y", "-loglevel", "error", "-f", "rawvideo", "-pix_fmt", "rgb24"]
    command += ["-s", f"{width}x{height}", "-r", str(rate), "-i", "-"]
    command += ["-c:v", "libx264", "-pix_fmt", "yuv420p", "-crf", "20"]
    with tempfile.TemporaryDirectory() as folder:
        made = Path(folder) / "movie.mp4"
        data = b"".join(picture.tobytes() for picture in pictures)
        done = subprocess.run([*command, str(made)], input=data, capture_output=True, check=False)
        if done.returncode:
            words = done.stderr.decode(errors="replace").strip().splitlines()[-1:]
            raise UsageError(f"ffmpeg made no movie: {' '.join(words)}")
        return made.read_bytes()
