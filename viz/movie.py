"""The coil turning as it packs, with the t(delta) curve drawing itself.

``python viz/movie.py RUN.h5 -o coil.mp4`` (with ffmpeg) or ``-o coil.gif`` (without).
"""

from __future__ import annotations

import argparse
import shutil
import sys
from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
from cover import draw_curve, paint_coil
from matplotlib.figure import Figure
from reading import run_shape
from shapes import coil_angle
from style import THEMES, Theme, parsed, started, use

from derod.outputs import replacing
from derod.terminal import say_done

TURNS = 0.75  # of the eye about the clamps' axis, over the movie
HOLD = 0.12  # of the frames show the end


def moments(run: Any, frames: int) -> np.ndarray:
    """End-shortenings (frames,) D to show: evenly from the first increment to the last, then
    held.
    """
    moving = max(round(frames * (1 - HOLD)), 2)
    delta = run.table["end_shortening"]
    path = np.linspace(delta[0], delta[-1], moving)
    return np.concatenate([path, np.full(max(frames - moving, 0), delta[-1])])


def draw_frame(figure: Figure, run: Any, end_shortening: float, angle: float, theme: Theme) -> None:
    """One picture: the coil seen from ``angle`` (rad) about the clamps' axis, and the curve so
    far.
    """
    figure.clear()
    shape = run_shape(run, end_shortening)
    paint_coil(figure.add_axes((0.0, 0.0, 0.6, 1.0)), run, shape, theme, angle)
    draw_curve(figure.add_axes((0.685, 0.2, 0.295, 0.65)), run, shape, theme)


def main(arguments: list[str] | None = None) -> int:
    """Paint the frames and put them together."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("file", help="run file (HDF5)")
    parser.add_argument("-o", "--output", required=True, help="OUT.mp4 or OUT.gif")
    parser.add_argument("--force", action="store_true", help="replace OUT if it exists")
    parser.add_argument("--frames", type=int, default=120)
    parser.add_argument("--rate", type=int, default=20, help="frames a second")
    parser.add_argument("--width", type=int, default=640, help="pixels")
    parser.add_argument("--colors", type=int, default=160, help="of a GIF's palette")
    parser.add_argument("--style", choices=sorted(THEMES), default="dark")
    args = parsed(parser, arguments)
    suffix = Path(args.output).suffix
    if suffix not in (".mp4", ".gif"):
        parser.error(f"-o {args.output}: allowed: a name that ends in .mp4 or .gif")
    if suffix == ".mp4" and shutil.which("ffmpeg") is None:
        parser.error("there is no ffmpeg for an .mp4; -o OUT.gif needs none")
    import derod

    with derod.open_run(args.file) as opened:
        pictures = paint(opened, args.frames, args.width, THEMES[args.style])
    with replacing(args.output, force=args.force) as passing:
        if suffix == ".gif":
            write_gif(pictures, passing, args.rate, args.colors)
        else:
            write_mp4(pictures, passing, args.rate)
    say_done(args.output)
    return 0


def paint(run: Any, frames: int, width: int, theme: Theme) -> list[np.ndarray]:
    """The frames, each (height, width, 3) of bytes, width and height even."""
    use(theme)
    dpi = 100
    figure = plt.figure(figsize=(width / dpi, 2 * round(0.23 * width) / dpi), dpi=dpi)
    begin = coil_angle(run_shape(run, float(run.table["end_shortening"][-1])))
    angles = begin + 2 * np.pi * TURNS * np.linspace(0, 1, frames)
    pictures = []
    for delta, angle in zip(moments(run, frames), angles, strict=True):
        draw_frame(figure, run, float(delta), float(angle), theme)
        figure.canvas.draw()
        pictures.append(np.asarray(figure.canvas.buffer_rgba())[:, :, :3].copy())
    plt.close(figure)
    return pictures


def write_gif(pictures: list[np.ndarray], output: str | Path, rate: int, colors: int) -> None:
    """One palette for all frames, taken from the last, so that nothing flickers."""
    from PIL import Image

    images = [Image.fromarray(picture) for picture in pictures]
    palette = images[-1].quantize(colors, method=Image.Quantize.MEDIANCUT)
    frames = [image.quantize(palette=palette, dither=Image.Dither.NONE) for image in images]
    frames[0].save(
        output,
        format="GIF",
        save_all=True,
        append_images=frames[1:],
        duration=1000 // rate,
        loop=0,
        optimize=True,
    )


def write_mp4(pictures: list[np.ndarray], output: str | Path, rate: int) -> None:
    """By ffmpeg, in a form that browsers play."""
    import subprocess

    height, width, _ = pictures[0].shape
    command = ["ffmpeg", "-y", "-loglevel", "error", "-f", "rawvideo", "-pix_fmt", "rgb24"]
    command += ["-s", f"{width}x{height}", "-r", str(rate), "-i", "-"]
    command += ["-c:v", "libx264", "-pix_fmt", "yuv420p", "-crf", "20", "-f", "mp4", str(output)]
    subprocess.run(command, input=b"".join(p.tobytes() for p in pictures), check=True)


if __name__ == "__main__":
    sys.exit(started(main))
