"""The picture of a fit, made and written."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from derod.views.plots.fit import draw_fit
from derod.views.plots.picture import Picture, make_picture, write_picture
from derod.views.plots.style import THEMES

if TYPE_CHECKING:
    from derod.fits.solving import Fit


def picture_of_fit(fit: Fit, style: str = "light") -> Picture:
    """The picture of a fit: data, curve, residuals."""
    theme = THEMES[style]
    return make_picture(lambda figure: draw_fit(figure, fit, theme), theme, window=False)


def write_fit(fit: Fit, path: Path, force: bool = False, style: str = "light") -> None:
    """Write the picture of a fit; raises what ``derod.files.outputs`` raises."""
    write_picture(picture_of_fit(fit, style), path, THEMES[style], 160, force)
