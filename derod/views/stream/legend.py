"""What colours and arrows of the 3D view mean: a strip with the scale of the rod's colour and a key."""

from __future__ import annotations

from typing import Any

import numpy as np
import rerun as rr

from derod.record import profiles as fields
from derod.views.stream.drawing import FORCE, PUSH

WIDTH, HEIGHT = 700.0, 96.0  # of the strip, in its own units
BAR, THICK, TOP = 240, 14, 4  # the bar's length, thickness and distance from the top
TEXT = (225, 228, 235)
TICKS = 3
KEYS = (
    (300.0, 16.0, "menisci", f"menisci and their pull, 1 K0/D² = {FORCE:g} D"),
    (300.0, 46.0, "wall", f"the wall's push, 1 K0/D³ = {PUSH:g} D"),
    (300.0, 76.0, "edge", "where the soft wall is singular"),
    (10.0, 82.0, "director", "the material d1"),
)
"""Place, name and meaning of every line and arrow."""
LINE = 26.0  # its length
DROP = 14.0  # how far below its point the viewer writes a label, and half a letter's width
LETTER = 3.1
EDGE = (150, 185, 220)


def draw_legend(
    recording: Any, scale: fields.Coloring, colors: dict[str, tuple[int, int, int]], wet: bool
) -> None:
    """Log the strip below "legend": the colour scale, and a line for each name in ``colors``."""
    values = np.linspace(scale.low, scale.high, BAR)
    picture = np.broadcast_to(fields.paint(values, scale)[None], (THICK, BAR, 3))
    recording.log("legend/scale", rr.Image(np.ascontiguousarray(picture)), static=True)
    recording.log("legend/scale", rr.Transform3D(translation=[10.0, TOP, 0.0]), static=True)
    shares = np.linspace(0.0, 1.0, TICKS)
    ticks = [f"{scale.low + share * (scale.high - scale.low):.3g}" for share in shares]
    _words(recording, "legend/ticks", [[10 + share * BAR, TOP + THICK] for share in shares], ticks)
    _words(recording, "legend/title", [[10 + BAR / 2, TOP + THICK + 22]], [scale.meaning])
    for x, y, name, meaning in KEYS:
        if not wet and name != "director":
            continue
        line = rr.LineStrips2D([[[x, y], [x + LINE, y]]], colors=[colors[name]], radii=2.0)
        recording.log(f"legend/{name}", line, static=True)
        middle = x + LINE + 6 + LETTER * len(meaning)  # labels are centred
        _words(recording, f"legend/{name}/words", [[middle, y - DROP]], [meaning])


def _words(recording: Any, entity: str, places: list[list[float]], words: list[str]) -> None:
    points = rr.Points2D(
        places, labels=words, show_labels=True, radii=0.01, colors=[TEXT] * len(places)
    )
    recording.log(entity, points, static=True)


def wall_edge(softness: float) -> Any:
    """Where the soft wall is singular, r = (1 + rho)/2, about the drop's centre: three great circles."""
    around = np.linspace(0, 2 * np.pi, 97)
    ring = 0.5 * (1 + softness) * np.stack([np.cos(around), np.sin(around), 0 * around], axis=-1)
    circles = [ring, np.roll(ring, 1, axis=1), np.roll(ring, 2, axis=1)]
    return rr.LineStrips3D(circles, colors=[(*EDGE, 110)], radii=0.0022)
