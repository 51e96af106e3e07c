"""A fit: measured forces with the fitted curve, and the weighted residuals below them."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure

from derod.views.plots.style import Theme

if TYPE_CHECKING:
    from derod.fits.solving import Fit


def draw_fit(figure: Figure, fit: Fit, theme: Theme) -> None:
    """Two panels over the displacement; residuals in standard errors where those were measured."""
    figure.set_size_inches(7.0, 6.0)
    upper, lower = figure.subplots(2, 1, sharex=True, gridspec_kw={"height_ratios": (2.2, 1.0)})
    data = fit.data
    scale, length = (1e3, "mm") if data.si else (1.0 / np.pi, "")
    size = 1e6 if data.si else 1.0
    x, force = data.displacement * scale, data.force * size
    error = size / data.weight if data.has_errors else None
    upper.errorbar(
        x, force, yerr=error, fmt="o", markersize=3.4, color=theme.paths["Ax"],
        ecolor=theme.paths["Ax"], elinewidth=0.9, label="measured", gid="data", zorder=3,
    )  # fmt: skip
    upper.plot(x, fit.model * size, color=theme.paths["3D"], linewidth=1.6, label="fitted",
               gid="model", zorder=4)  # fmt: skip
    upper.set_ylabel(r"force  $F$   ($\mu$N)" if data.si else r"tension  $t$   ($K_0/D^2$)")
    names = "\n".join(
        f"{key} = {value:.5g}" + (f" ± {error:.2g}" if np.isfinite(error) else ", not determined")
        for key, value, error in zip(fit.keys, fit.values, fit.errors, strict=True)
    )
    low = "lower right" if force[-1] >= force[0] else "lower left"
    upper.legend(loc=low, title=names, title_fontsize=9.5, fontsize=9.5, alignment="left")
    lower.axhline(0.0, color=theme.faint, linewidth=1.0, zorder=1)
    if data.has_errors:
        lower.axhspan(-2.0, 2.0, color=theme.faint, alpha=0.35, linewidth=0, zorder=0)
        lower.set_ylabel("residual\n(standard errors)")
    else:
        lower.set_ylabel("weighted residual")
    residuals = fit.residuals
    lower.vlines(x, 0.0, residuals, color=theme.paths["Ax"], linewidth=1.0, zorder=2)
    lower.plot(
        x, residuals, "o", markersize=3.4, color=theme.paths["Ax"], gid="residuals", zorder=3
    )
    lower.set_xlabel(
        f"displacement  $\\Delta$   ({length})"
        if data.si
        else r"end-shortening  $\delta/\pi$   ($D$)"
    )
