"""The parts of E_hat along a push, stacked: ``python viz/energies.py RUN.h5 -o OUT.pdf``."""

from __future__ import annotations

import argparse
import sys
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from reading import open_files
from style import LABELS, THEMES, Theme, add_output, new_figure, parsed, save, started, use

NAMES = {
    "bend": "bending",
    "twist": "twist",
    "wall": "soft wall",
    "capillary": r"capillary, $f_\gamma(\delta+1-\ell_{in})$",
}


def parts(run: Any) -> dict[str, np.ndarray]:
    """Parts (T,) that add up to E_hat; the capillary one holds the reference f_gamma (delta +
    1).
    """
    table = run.table
    lifted = run.scene.drop.capillary_force * (table["end_shortening"] + 1)
    return {
        "bend": table["energy_bend"],
        "twist": table["energy_twist"],
        "wall": table["energy_wall"],
        "capillary": table["energy_capillary"] + lifted,
    }


def figure(run: Any, theme: Theme) -> Figure:
    """Stacked parts and their sum against delta/pi, events marked."""
    use(theme)
    made = new_figure(6.6, 4.0)
    axes = made.subplots()
    delta = run.table["end_shortening"] / np.pi
    stacked = parts(run)
    axes.stackplot(
        delta,
        *stacked.values(),
        labels=[NAMES[name] for name in stacked],
        colors=theme.parts,
        alpha=0.85,
        linewidth=0,
    )
    axes.plot(delta, run.table["energy_hat"], color=theme.ink, linewidth=1.6, label=r"$\hat{E}$")
    for event in run.events:
        if event.kind in ("instability", "snap"):
            where = event.end_shortening / np.pi
            axes.axvline(where, color=theme.ink, linewidth=0.8, linestyle=(0, (2, 3)), gid="event")
            axes.annotate(
                event.kind,
                (where, 0.98),
                xycoords=("data", "axes fraction"),
                rotation=90,
                xytext=(-3, 0),
                textcoords="offset points",
                ha="right",
                va="top",
                fontsize=9,
            )
    axes.set_xlim(0, delta.max())
    axes.set_ylim(bottom=0)
    axes.set_xlabel(LABELS["delta"])
    axes.set_ylabel(LABELS["energy_hat"])
    axes.legend(loc="upper left", bbox_to_anchor=(0.12, 1.0), fontsize=9.5, reverse=True)
    return made


def main(arguments: list[str] | None = None) -> int:
    """Draw the energies of a run."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("file", help="run file (HDF5)")
    add_output(parser)
    args = parsed(parser, arguments)
    save(
        figure(open_files([args.file]).runs[0], THEMES[args.style]),
        args.output,
        args.dpi,
        args.force,
    )
    return 0


if __name__ == "__main__":
    sys.exit(started(main))
